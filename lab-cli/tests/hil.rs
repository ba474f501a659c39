//! `lab hil` as a user calls it wrongly; `cargo xtask hil` calls it rightly, with the firmware's image.

use crate::common::Place;
use predicates::prelude::*;
use predicates::str::contains;

#[test]
fn it_must_be_told_where_the_firmware_runs() {
    let place = Place::new();
    place.lab().arg("hil").assert().failure().stderr(contains("--qemu").and(contains("--port")));
    place.lab().args(["hil", "--qemu", "--port", "x"]).assert().failure().stderr(contains("cannot be used with"));
}

#[test]
fn a_missing_image_is_named_with_the_command_that_builds_it() {
    let place = Place::new();
    let lab = place.lab().args(["hil", "--qemu", "--image", "no-such.elf"]).assert().failure();
    lab.stderr(contains("no-such.elf").and(contains("cargo xtask hil")));
}

#[test]
fn a_port_that_is_not_there_is_named() {
    let place = Place::new();
    place.lab().args(["hil", "--port", "/dev/no-such-port"]).assert().failure().stderr(contains("/dev/no-such-port"));
}
