//! The structure of slam-core: imports go one way, and each equation is where the documents say.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Modules in the order in which they build on one another; those of one line do not know each other.
const LAYERS: &[&[&str]] = &[
    &["rig", "sample", "report"],
    &["geometry"],
    &["hand_over"],
    &["filter"],
    &["motion"],
    &["sensing"],
    &["walls"],
    &["measurement"],
    &["births", "jolts"],
    &["holds"],
    &["config", "clock", "health"],
    &["slam"],
    &["view", "counted", "extended", "frozen_sensors", "displacement", "dock", "restart", "take_over", "kept"],
    &["take_up"],
    &["second_copy"],
];

fn source() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../slam-core/src")
}

/// Every source file but for tests and the list of modules, by its module path: `filter::covariance` for
/// `filter/covariance/product.rs`, too, which is a part of it.
fn files(folder: &Path, path: &[String], found: &mut Vec<(String, String)>) {
    for entry in fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path()) {
        let name = entry.file_stem().and_then(|stem| stem.to_str()).expect("a plain name").to_owned();
        if entry.is_dir() {
            if name != "tests" {
                files(&entry, &[path, &[name]].concat(), found);
            }
        } else if !(path.is_empty() && name == "lib") {
            let inner = if name == "mod" { path.to_vec() } else { [path, &[name]].concat() };
            let module: Vec<&str> = inner.iter().take(2).map(String::as_str).collect();
            found.push((module.join("::"), fs::read_to_string(&entry).expect("a source file")));
        }
    }
}

/// The modules that each module imports, `crate::` and `super::` resolved.
fn imports() -> BTreeMap<String, BTreeSet<String>> {
    let mut found = Vec::new();
    files(&source(), &[], &mut found);
    let modules: BTreeSet<String> = found.iter().map(|(module, _)| module.clone()).collect();
    let mut imports: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for (module, text) in &found {
        let folder = module.split("::").next().unwrap_or(module);
        let text = text.replace("super::", &format!("crate::{folder}::"));
        let of_module = imports.entry(module.clone()).or_default();
        for path in text.split("crate::").skip(1) {
            let names = path.split(|c: char| !(c.is_alphanumeric() || c == '_' || c == ':')).next().unwrap_or_default();
            let mut parts = names.split("::");
            let (first, second) = (parts.next().unwrap_or_default(), parts.next().unwrap_or_default());
            let inner = format!("{first}::{second}");
            let target = if modules.contains(&inner) { inner } else { first.to_owned() };
            if target != *module && modules.contains(&target) {
                of_module.insert(target);
            }
        }
    }
    imports
}

fn layer(module: &str) -> usize {
    let top = module.split("::").next().unwrap_or(module);
    let found = LAYERS.iter().position(|layer| layer.contains(&top));
    found.unwrap_or_else(|| panic!("{module} is in no layer"))
}

#[test]
fn no_module_reaches_back() {
    let imports = imports();
    assert!(imports.len() > 40, "{imports:?}");
    for (module, targets) in &imports {
        for target in targets {
            let own = module.split("::").next() == target.split("::").next();
            assert!(own || layer(target) < layer(module), "{module} imports {target}");
        }
    }
}

#[test]
fn no_imports_go_in_a_circle() {
    let mut imports = imports();
    // What imports nothing that is left is laid aside, until nothing is left.
    while !imports.is_empty() {
        let left: BTreeSet<String> = imports.keys().cloned().collect();
        let before = imports.len();
        imports.retain(|_, targets| targets.iter().any(|target| left.contains(target)));
        assert!(imports.len() < before, "a circle among {left:?}");
    }
}

#[test]
fn each_equation_is_where_the_documents_say() {
    let page = fs::read_to_string(source().join("../../docs/explanation/architecture.md")).expect("the document");
    let table = page.split_once("## From the paper to the code").expect("the section").1;
    let table = table.split("\n## ").next().expect("its text");
    let rows: Vec<Vec<&str>> = table
        .lines()
        .filter(|line| line.contains(".rs`"))
        .map(|line| line.trim_matches('|').split('|').map(str::trim).collect())
        .collect();
    for equation in ["(1)", "(2)", "(3)", "(4)", "(5)", "3.1", "3.2", "3.3", "3.4"] {
        assert!(rows.iter().any(|row| row[0].contains(equation)), "{equation} is nowhere");
    }
    for row in rows {
        let [_, _, function, file] = row[..] else { panic!("{row:?} has not four columns") };
        let [function, file] = [function, file].map(|cell| cell.trim_matches('`'));
        let text = fs::read_to_string(source().join(file)).unwrap_or_else(|error| panic!("{file}: {error}"));
        let name = function.rsplit("::").next().unwrap_or(function);
        let is_there = ["fn", "struct", "enum", "const"]
            .iter()
            .any(|kind| [" ", "(", "<", ":"].iter().any(|end| text.contains(&format!("{kind} {name}{end}"))));
        assert!(is_there, "{function} is not in {file}");
        if let Some((kind, _)) = function.split_once("::") {
            assert!(text.contains(&format!("impl {kind}")) || text.contains(&format!("> {kind}")), "{kind} in {file}");
        }
    }
}
