//! The workbench's binary; everything is in the library.

fn main() -> std::process::ExitCode {
    lab::cli::main()
}
