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
    let map = fs::read_to_string(root().join("docs/architecture.md")).expect("the document");
    let files = sources(&root().join("slam-core/src"));
    assert!(files.len() > 30, "{files:?}");
    for file in files.iter().filter(|file| *file != "lib.rs") {
        assert!(map.contains(&format!("`{file}`")), "docs/architecture.md does not say what {file} is");
    }
    // And none that is not there.
    let section = map.split_once("## The files of slam-core").expect("the section").1;
    let section = section.split("\n## ").next().expect("its text");
    for name in section.split('`').filter(|name| name.ends_with(".rs")) {
        assert!(root().join("slam-core/src").join(name).is_file(), "docs/architecture.md names {name}");
    }
}

/// The targets of the links `[text](target)` in a Markdown text.
fn links(text: &str) -> impl Iterator<Item = &str> {
    text.split("](").skip(1).filter_map(|rest| rest.split_once(')')).map(|(target, _)| target)
}

#[test]
fn every_link_leads_to_a_file() {
    let mut documents: Vec<PathBuf> = vec![root().join("README.md"), root().join("CHANGELOG.md")];
    documents.extend(names(&root().join("docs"), ".md").iter().map(|name| root().join("docs").join(name)));
    let mut checked = 0;
    for document in &documents {
        let text = fs::read_to_string(document).expect("the document");
        for target in links(&text).filter(|target| !target.contains("://") && !target.starts_with('#')) {
            let file = target.split('#').next().expect("a path");
            let beside = document.parent().expect("a folder").join(file);
            assert!(beside.exists(), "{}: {target} is not there", document.display());
            checked += 1;
        }
    }
    assert!(checked > 10, "{checked} links only");
}
