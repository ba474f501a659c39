//! Hands the memory map at the root of the repository to the linker.

fn main() {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/..");
    println!("cargo:rerun-if-changed={root}/memory.x");
    let feature = |name: &str| std::env::var_os(format!("CARGO_FEATURE_{name}")).is_some();
    if feature("BOARD") || feature("HIL") || feature("FAIL_SAFE") {
        println!("cargo:rustc-link-search={root}");
        println!("cargo:rustc-link-arg-bins=-Tlink.x");
    }
    if feature("BOARD") {
        println!("cargo:rustc-link-arg-bins=-Tdefmt.x");
    }
}
