//! What the documents say about the project's files.

use std::fs;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn names(folder: &Path, ending: &str) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let names = entries.map(|entry| entry.expect("an entry").file_name().into_string().expect("a plain name"));
    names.filter(|name| name.ends_with(ending)).collect()
}

/// The source files below a folder but for tests and for lists of modules, by their paths from there.
fn sources(folder: &Path) -> Vec<String> {
    let mut files: Vec<String> = names(folder, ".rs").into_iter().filter(|file| file != "mod.rs").collect();
    for entry in fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path()) {
        let name = entry.file_name().expect("a name").to_str().expect("a plain name").to_owned();
        if entry.is_dir() && name != "tests" {
            files.extend(sources(&entry).iter().map(|file| format!("{name}/{file}")));
        }
    }
    files
}

#[test]
fn the_map_of_files_names_every_file_of_the_estimator() {
    let map = fs::read_to_string(root().join("docs/explanation/architecture.md")).expect("the document");
    let files = sources(&root().join("slam-core/src"));
    assert!(files.len() > 30, "{files:?}");
    for file in files.iter().filter(|file| *file != "lib.rs") {
        assert!(map.contains(&format!("`{file}`")), "docs/explanation/architecture.md does not say what {file} is");
    }
    // And none that is not there.
    let section = map.split_once("## The files of slam-core").expect("the section").1;
    let section = section.split("\n## ").next().expect("its text");
    for name in section.split('`').filter(|name| name.ends_with(".rs")) {
        assert!(root().join("slam-core/src").join(name).is_file(), "docs/explanation/architecture.md names {name}");
    }
}

/// Every Markdown file of the project, by its path from the root.
fn documents() -> Vec<PathBuf> {
    let mut documents = Vec::new();
    let mut folders = vec![root(), root().join(".github"), root().join("docs")];
    let crates = ["slam-core", "robot", "wire", "hal-sim", "lab", "firmware", "fuzz"];
    folders.extend(crates.map(|name| root().join(name)).into_iter().filter(|folder| folder.is_dir()));
    while let Some(folder) = folders.pop() {
        documents.extend(names(&folder, ".md").iter().map(|name| folder.join(name)));
        if folder.starts_with(root().join("docs")) {
            let entries = fs::read_dir(&folder).expect("the folder").map(|entry| entry.expect("an entry").path());
            folders.extend(entries.filter(|path| path.is_dir()));
        }
    }
    documents
}

/// The targets of the links `[text](target)` in a Markdown text.
fn links(text: &str) -> impl Iterator<Item = &str> {
    text.split("](").skip(1).filter_map(|rest| rest.split_once(')')).map(|(target, _)| target)
}

/// The anchors of a Markdown text's headings, as the forges make them.
fn anchors(text: &str) -> Vec<String> {
    let headings = text.lines().filter(|line| line.starts_with('#')).map(|line| line.trim_start_matches('#').trim());
    let kept = |c: &char| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_');
    headings.map(|heading| heading.to_lowercase().chars().filter(kept).collect::<String>().replace(' ', "-")).collect()
}

#[test]
fn every_link_leads_to_a_file_and_a_heading() {
    let mut checked = 0;
    for document in documents() {
        let text = fs::read_to_string(&document).expect("the document");
        for target in links(&text).filter(|target| !target.contains("://")) {
            let (file, anchor) = target.split_once('#').unwrap_or((target, ""));
            let beside = document.parent().expect("a folder").join(file);
            let led_to = if file.is_empty() { document.clone() } else { beside };
            assert!(led_to.exists(), "{}: {target} is not there", document.display());
            if !anchor.is_empty() {
                let text = fs::read_to_string(&led_to).expect("a document");
                let found = anchors(&text).iter().any(|heading| heading == anchor);
                assert!(found, "{}: {target} has no such heading", document.display());
            }
            checked += 1;
        }
    }
    assert!(checked > 50, "{checked} links only");
}

#[test]
fn the_index_leads_to_every_page() {
    let docs = root().join("docs");
    let index = docs.join("README.md");
    let text = fs::read_to_string(&index).expect("the index");
    let linked: Vec<PathBuf> = links(&text).filter_map(|target| docs.join(target).canonicalize().ok()).collect();
    for page in documents().iter().filter(|page| page.starts_with(&docs) && **page != index) {
        let path = page.canonicalize().expect("it is there");
        assert!(linked.contains(&path), "docs/README.md does not lead to {}", page.display());
    }
}

#[test]
fn every_file_that_a_page_names_is_there() {
    let is_path = |word: &&str| {
        word.contains('/') && !word.starts_with('/') && word.chars().all(|c| c.is_alphanumeric() || "/._-".contains(c))
    };
    let mut checked = 0;
    for document in documents() {
        let text = fs::read_to_string(&document).expect("the document");
        for name in text.split('`').skip(1).step_by(2).filter(is_path) {
            let first = root().join(name.split('/').next().expect("a part"));
            // Other words with a slash are none of ours: a unit, what a run writes, a topic.
            if first.is_dir() && !name.starts_with("out/") && !name.starts_with("target/") {
                assert!(root().join(name).exists(), "{} names {name}", document.display());
                checked += 1;
            }
        }
    }
    assert!(checked > 20, "{checked} names only");
}
