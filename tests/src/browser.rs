//! A page in a real browser, without a driver: headless Chromium loads a copy of the page that ends with a script of
//! ours, and prints the document that results.

use serde_json::Value;
use std::{
    env, fs,
    io::{self, Read, Write},
    path::{Path, PathBuf},
    process::{Child, Command, Stdio},
    thread,
    time::{Duration, Instant},
};

const NAMES: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];

/// Long enough for a busy machine; a browser that hangs must not hang the tests.
const PATIENCE: Duration = Duration::from_secs(120);

/// A browser that was found on this machine.
pub struct Browser {
    program: PathBuf,
    /// Width of its window, CSS pixels; 500 is the least that Chromium takes, and a phone's layout on this page.
    pub width_px: u32,
}

/// What became of a page.
pub struct Visit {
    /// What the probe returned.
    pub answer: Value,
    /// `data-ready` and `data-errors` of the document element.
    pub ready: bool,
    /// Faults that the page counted; `None` where it could not even count.
    pub errors: Option<u32>,
    /// What the page wrote to the console.
    pub console: Vec<String>,
}

impl Browser {
    /// `$CHROME`, or the first of the usual names on the path.
    ///
    /// Where there is none: on a CI machine (`$CI` set) a panic, elsewhere a loud message and `None`.
    pub fn find() -> Option<Self> {
        let path = env::var_os("PATH").unwrap_or_default();
        let on_path = || env::split_paths(&path).flat_map(|dir| NAMES.map(|name| dir.join(name)));
        let program = env::var_os("CHROME").map(PathBuf::from).or_else(|| on_path().find(|file| file.is_file()));
        if program.is_none() {
            let message = "SKIPPED: the report page was not checked, for no browser was found.\n\
                 Install Chromium (`cargo xtask setup`, or on Debian `apt-get install chromium`), or name it in $CHROME.";
            assert!(env::var_os("CI").is_none(), "{message}");
            // Straight to the stream: the test harness would swallow what a passing test prints.
            let _ = writeln!(io::stderr(), "\n{message}\n");
        }
        program.map(|program| Self { program, width_px: 1200 })
    }

    /// The program.
    pub fn program(&self) -> &Path {
        &self.program
    }

    /// Opens `html` with `hash` behind its address, runs `probe` (the body of an asynchronous function) when it has
    /// loaded, and returns what that returned. There is no network. The page and the browser's profile go into `dir`,
    /// which is emptied first.
    ///
    /// # Panics
    /// The browser cannot be started, hangs, or prints no document.
    pub fn visit(&self, dir: &Path, html: &str, hash: &str, probe: &str) -> Visit {
        let _ = fs::remove_dir_all(dir);
        fs::create_dir_all(dir).expect("a folder for the page");
        let page = dir.join("page.html");
        fs::write(&page, with_probe(html, probe)).expect("the page can be written");
        let page = page.canonicalize().expect("the page was written");
        let mut child = Command::new(&self.program)
            .args(["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"])
            .args(["--disable-background-networking", "--disable-component-update", "--disable-sync"])
            .args(["--host-resolver-rules=MAP * ~NOTFOUND", "--proxy-server=127.0.0.1:9", "--enable-logging=stderr"])
            .args(["--virtual-time-budget=60000", "--dump-dom"])
            .arg(format!("--window-size={},900", self.width_px))
            .arg(format!("--user-data-dir={}", dir.join("profile").display()))
            .arg(format!("file://{}#{hash}", page.display()))
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap_or_else(|error| panic!("{} does not start: {error}", self.program.display()));
        let (dom, log) = outputs(&mut child);
        read_visit(&dom, &log)
    }
}

/// The page with our script at its end. What the script returns goes into an element of its own.
///
/// The browser runs in virtual time, which leaps to the next timer whenever nothing is due. Frames would come in real
/// time, too late for it; so they become timers, and the probe's `settle` and `until` wait in virtual time too.
fn with_probe(html: &str, probe: &str) -> String {
    let frames = "<head><script>\
         window.requestAnimationFrame = (paint) => setTimeout(() => paint(performance.now()), 16);\
         </script>";
    let script = format!(
        "<script>(async () => {{\n\
         const settle = (ms = 100) => new Promise((done) => setTimeout(done, ms));\n\
         const until = async (met) => {{ for (let i = 0; i < 300 && !met(); i++) await settle(); }};\n\
         await settle();\n\
         let answer;\n\
         try {{ answer = await (async () => {{ {probe} }})(); }} catch (fault) {{ answer = {{ fault: String(fault) }}; }}\n\
         const box = document.createElement('output');\n\
         box.id = 'probe';\n\
         box.textContent = encodeURIComponent(JSON.stringify(answer ?? null));\n\
         document.body.append(box);\n\
         }})();</script></body>"
    );
    html.replacen("<head>", frames, 1).replace("</body>", &script)
}

/// Standard output and error of a browser, which is ended when it takes too long.
fn outputs(child: &mut Child) -> (String, String) {
    let reader = |stream: Option<Box<dyn Read + Send>>| {
        thread::spawn(move || {
            let mut bytes = Vec::new();
            let _ = stream.expect("piped").read_to_end(&mut bytes);
            String::from_utf8_lossy(&bytes).into_owned()
        })
    };
    let out = reader(child.stdout.take().map(|s| Box::new(s) as _));
    let err = reader(child.stderr.take().map(|s| Box::new(s) as _));
    let deadline = Instant::now() + PATIENCE;
    while child.try_wait().expect("the browser can be waited for").is_none() {
        if Instant::now() > deadline {
            let _ = child.kill();
            let _ = child.wait();
            panic!("the browser did not finish within {PATIENCE:?}");
        }
        thread::sleep(Duration::from_millis(20));
    }
    (out.join().expect("stdout"), err.join().expect("stderr"))
}

fn read_visit(dom: &str, log: &str) -> Visit {
    let between = |text: &'_ str, from: &str, to: &str| -> Option<String> {
        text.split_once(from)?.1.split_once(to).map(|(value, _)| value.to_string())
    };
    let root = between(dom, "<html", ">").unwrap_or_else(|| panic!("the browser printed no document:\n{log}"));
    let answer = between(dom, "<output id=\"probe\">", "</output>").map(|text| percent_decode(&text));
    Visit {
        answer: answer.and_then(|text| serde_json::from_str(&text).ok()).unwrap_or(Value::Null),
        ready: root.contains("data-ready=\"true\""),
        errors: between(&root, "data-errors=\"", "\"").and_then(|n| n.parse().ok()),
        console: log.lines().filter(|line| line.contains(":CONSOLE")).map(str::to_string).collect(),
    }
}

fn percent_decode(text: &str) -> String {
    let mut bytes = Vec::new();
    let mut rest = text.as_bytes();
    while let [first, tail @ ..] = rest {
        let code = if *first == b'%' { tail.get(..2) } else { None };
        let code = code.and_then(|hex| u8::from_str_radix(std::str::from_utf8(hex).ok()?, 16).ok());
        bytes.push(code.unwrap_or(*first));
        rest = if code.is_some() { &tail[2..] } else { tail };
    }
    String::from_utf8_lossy(&bytes).into_owned()
}
