//! The studio: a folder of files that any web server serves.

use std::fs;
use std::io::Write;
use std::net::TcpListener;
use std::path::{Path, PathBuf};

use flate2::Compression;
use flate2::write::GzEncoder;
use wasm_bindgen_cli_support::Bindgen;

use crate::run::{ACROSS, Result, cargo, root, run, target_dir};
use crate::wasm::{TARGET, Wasm};

/// Most that the page's program may be when it is compressed as web servers do, bytes.
const PROGRAM_BUDGET: usize = 1_500_000;

/// The studio's own scripts, in the order in which they build on each other; those of the crate `pages` come before.
const SCRIPTS: [&str; 14] = [
    "files.js",
    "live.js",
    "live_clock.js",
    "live_floor.js",
    "look_back.js",
    "live_map.js",
    "live_charts.js",
    "plan_text.js",
    "tools.js",
    "simulate.js",
    "replay.js",
    "errands.js",
    "watch.js",
    "main.js",
];

/// What the scripts use of the program.
const IMPORT: &str =
    "import init, { Replay, Robot, Simulation, built_in_plans, robot_command, tuned_rig } from \"./program.js\";\n";

/// Builds the page and prints its folder last.
pub fn studio() -> Result {
    let folder = build()?;
    println!("{}", folder.display());
    Ok(())
}

/// Builds the page and serves it until it is stopped.
pub fn serve() -> Result {
    let folder = build()?;
    let failed = |error: std::io::Error| format!("the server: {error}");
    let listener = TcpListener::bind("127.0.0.1:8090").or_else(|_| TcpListener::bind("127.0.0.1:0")).map_err(failed)?;
    println!("http://{}/ serves {}", listener.local_addr().map_err(failed)?, folder.display());
    pages::serve::serve(&listener, &folder).map_err(failed)
}

/// Builds the page and runs its tests in a browser.
pub fn test() -> Result {
    let folder = build()?;
    run(cargo(&ACROSS).args(["--ignored", "studio::"]).env("STUDIO_PAGE", folder))
}

/// Builds the page and measures it in a browser.
pub fn measure() -> Result {
    let folder = build()?;
    run(cargo(&["run", "--release", "--package", "tests", "--example", "studio_speed"]).env("STUDIO_PAGE", folder))
}

/// Builds the page: its folder.
pub fn build() -> Result<PathBuf> {
    let folder = target_dir().join("studio-page");
    let failed = |error: std::io::Error| format!("{}: {error}", folder.display());
    if folder.exists() {
        fs::remove_dir_all(&folder).map_err(failed)?;
    }
    fs::create_dir_all(&folder).map_err(failed)?;
    let program = compile()?;
    let mut bindgen = Bindgen::new();
    bindgen
        .input_path(program)
        .out_name("program")
        .omit_default_module_path(false)
        .typescript(false)
        .keep_debug(false)
        .remove_producers_section(true);
    bindgen
        .web(true)
        .and_then(|bindgen| bindgen.generate(&folder))
        .map_err(|error| format!("wasm-bindgen: {error:#}"))?;
    let read = |path: &Path| fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()));
    let page = root().join("studio/page");
    let mut script = IMPORT.to_owned() + &pages::VIEWS.concat();
    for name in SCRIPTS {
        script += &read(&page.join("js").join(name))?;
    }
    let note = "Walls and hits as they were estimated up to the moment on the slider.";
    let sections = pages::SECTIONS.replace("{{MAP_NOTE}}", note);
    let words = [("EYEBROW", "Studio"), ("TITLE", "A robot maps a home"), ("VERDICT", "Loading the estimator.")];
    let fill = |text: String, (name, word): (&str, &str)| text.replace(&format!("{{{{{name}}}}}"), word);
    let header = words.into_iter().fold(pages::HEADER.to_owned(), fill);
    let index = [("HEADER", header.as_str()), ("VIEWS", &sections)].into_iter();
    let files = [
        ("index.html", index.fold(read(&page.join("index.html"))?, fill)),
        ("app.css", pages::STYLE.to_owned() + &read(&page.join("studio.css"))?),
        ("app.js", script),
    ];
    for (name, text) in files {
        fs::write(folder.join(name), text).map_err(failed)?;
    }
    let bytes = compressed(&folder.join("program_bg.wasm"))?;
    println!("the program is {bytes} bytes compressed, of {PROGRAM_BUDGET}");
    if bytes > PROGRAM_BUDGET { Err("the studio's program is over its budget".into()) } else { Ok(folder) }
}

fn compile() -> Result<PathBuf> {
    let wasm = Wasm::require()?;
    run(wasm.cargo("build").args(["--package", "studio", "--lib", "--profile", "studio"]))?;
    Ok(wasm.target_dir().join(TARGET).join("studio/studio.wasm"))
}

/// Size of a file under gzip, bytes.
fn compressed(file: &Path) -> Result<usize> {
    let failed = |error: std::io::Error| format!("{}: {error}", file.display());
    let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
    encoder.write_all(&fs::read(file).map_err(failed)?).map_err(failed)?;
    Ok(encoder.finish().map_err(failed)?.len())
}
