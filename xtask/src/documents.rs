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
