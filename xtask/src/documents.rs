//! What the documents say twice must agree.

use crate::run::root;

#[test]
fn the_pin_map_is_the_boards() {
    let read = |name: &str| std::fs::read_to_string(root().join(name)).unwrap();
    let (board, hardware) = (read("firmware/src/bin/robot/board.rs"), read("docs/guide/hardware.md"));
    let rows: Vec<&str> = board.lines().filter_map(|line| line.strip_prefix("//! |")).collect();
    assert!(rows.len() > 10);
    for row in rows {
        assert!(
            hardware.lines().any(|line| line.strip_prefix('|') == Some(row)),
            "docs/guide/hardware.md lacks |{row}"
        );
    }
}

/// The manifests of all crates of both workspaces.
fn manifests() -> Vec<std::path::PathBuf> {
    let folders = [root().to_owned(), root().join("firmware")].map(|folder| std::fs::read_dir(folder).unwrap());
    let manifests = folders.into_iter().flatten().map(|entry| entry.unwrap().path().join("Cargo.toml"));
    manifests.filter(|manifest| manifest.is_file()).collect()
}

#[test]
fn every_crate_has_the_lints_and_the_version_of_its_workspace() {
    let manifests = manifests();
    assert!(manifests.len() > 12, "{manifests:?}");
    for manifest in manifests {
        let text = std::fs::read_to_string(&manifest).unwrap();
        // A crate that tools keep outside both workspaces is a workspace of its own.
        let is_apart = text.contains("[workspace]") && !text.contains("[workspace.lints");
        let takes = ["[lints]\nworkspace = true", "version.workspace = true"].iter().all(|line| text.contains(line));
        assert!(
            is_apart || takes,
            "{}: no `[lints] workspace = true` or `version.workspace = true`",
            manifest.display()
        );
    }
}

#[test]
fn the_citation_and_the_workspaces_have_one_version() {
    let version = format!("version = \"{}\"", env!("CARGO_PKG_VERSION"));
    let read = |name: &str| std::fs::read_to_string(root().join(name)).unwrap();
    for manifest in ["Cargo.toml", "firmware/Cargo.toml"] {
        assert!(read(manifest).contains(&version), "{manifest} has another version");
    }
    assert!(read("CITATION.cff").contains(&format!("version: {}\n", env!("CARGO_PKG_VERSION"))));
    assert!(read("CHANGELOG.md").contains(env!("CARGO_PKG_VERSION")), "the changelog does not know the version");
}
