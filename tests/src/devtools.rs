//! A page in a real browser as a user meets it, in real time: headless Chromium, driven over its debugging protocol.

use std::io::{BufRead, BufReader, Write};
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use std::{fs, thread};

use serde_json::{Value, json};
use tungstenite::stream::MaybeTlsStream;
use tungstenite::{Message, WebSocket};

use crate::browser::Browser;

/// Long enough for a busy machine; a browser that hangs must not hang the tests.
const PATIENCE: Duration = Duration::from_secs(90);

/// An open page. The browser ends with it.
pub struct Page {
    browser: Child,
    socket: WebSocket<MaybeTlsStream<TcpStream>>,
    session: String,
    last_id: u64,
    /// Addresses that the page asked for, but for `data:` and `blob:`, which go nowhere.
    pub requests: Vec<String>,
    /// Warnings and errors on the page's console, and faults that it did not catch.
    pub console: Vec<String>,
}

/// The address of a server for this folder, which lives as long as the tests.
pub fn serve(folder: &Path) -> String {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = format!("http://{}/", listener.local_addr().expect("its address"));
    let folder = folder.to_owned();
    thread::spawn(move || pages::serve::serve(&listener, &folder));
    address
}

impl Page {
    /// Opens an address in a window of this size, CSS pixels, after a script of ours has run in the page. `dir` is for the browser's
    /// profile and is emptied first.
    pub fn open(browser: &Browser, dir: &Path, address: &str, [width, height]: [u32; 2], first: &str) -> Self {
        let _ = fs::remove_dir_all(dir);
        fs::create_dir_all(dir).expect("a folder for the profile");
        let mut child = Command::new(browser.program())
            .args(["--headless", "--no-sandbox", "--disable-quic", "--no-first-run", "--remote-debugging-port=0"])
            .args([
                "--disable-background-networking",
                "--disable-component-update",
                "--disable-sync",
                "--hide-scrollbars",
            ])
            .args(["--host-resolver-rules=MAP * ~NOTFOUND , EXCLUDE 127.0.0.1"])
            .arg(format!("--window-size={width},{height}"))
            .arg(format!("--user-data-dir={}", dir.join("profile").display()))
            .arg("about:blank")
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap_or_else(|error| panic!("{} does not start: {error}", browser.program().display()));
        let mut lines = BufReader::new(child.stderr.take().expect("piped")).lines();
        let debugger = lines
            .find_map(|line| line.ok()?.strip_prefix("DevTools listening on ").map(str::to_owned))
            .expect("the browser says where its debugger is");
        // What else it says must be read, or it would wait.
        thread::spawn(move || lines.for_each(drop));
        let (socket, _) = tungstenite::connect(debugger.as_str()).expect("the debugger answers");
        if let MaybeTlsStream::Plain(stream) = socket.get_ref() {
            stream.set_read_timeout(Some(PATIENCE)).expect("a timeout");
        }
        let (requests, console) = (Vec::new(), Vec::new());
        let mut page = Self { browser: child, socket, session: String::new(), last_id: 0, requests, console };
        let target = page.call("Target.createTarget", &json!({ "url": "about:blank" }));
        let attached = page.call("Target.attachToTarget", &json!({ "targetId": target["targetId"], "flatten": true }));
        page.session = attached["sessionId"].as_str().expect("a session").to_owned();
        let size = json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": false });
        page.call("Emulation.setDeviceMetricsOverride", &size);
        for domain in ["Page", "Runtime", "Log", "Network"] {
            page.call(&format!("{domain}.enable"), &json!({}));
        }
        page.call("Page.addScriptToEvaluateOnNewDocument", &json!({ "source": first }));
        page.call("Page.navigate", &json!({ "url": address }));
        page
    }

    /// What the protocol's method returns.
    ///
    /// # Panics
    /// The browser refuses it or does not answer.
    pub fn call(&mut self, method: &str, parameters: &Value) -> Value {
        self.last_id += 1;
        let mut request = json!({ "id": self.last_id, "method": method, "params": parameters });
        if !self.session.is_empty() {
            request["sessionId"] = json!(self.session);
        }
        self.socket.send(Message::text(request.to_string())).expect("the browser listens");
        loop {
            let message = self.socket.read().unwrap_or_else(|error| panic!("{method}: {error}"));
            let Ok(text) = message.into_text() else { continue };
            let Ok(message) = serde_json::from_str::<Value>(&text) else { continue };
            if message["id"] == self.last_id {
                assert!(message.get("error").is_none(), "{method}: {}", message["error"]);
                return message["result"].clone();
            }
            self.note(&message);
        }
    }

    /// Keeps what the page did that nobody asked for.
    fn note(&mut self, message: &Value) {
        let parameters = &message["params"];
        match message["method"].as_str() {
            Some("Network.requestWillBeSent") => {
                let address = parameters["request"]["url"].as_str().unwrap_or_default();
                if !["data:", "blob:", "about:"].iter().any(|start| address.starts_with(start)) {
                    self.requests.push(address.to_owned());
                }
            }
            Some("Network.webSocketCreated") => {
                self.requests.push(parameters["url"].as_str().unwrap_or_default().to_owned());
            }
            Some("Runtime.consoleAPICalled") if ["error", "warning"].iter().any(|kind| parameters["type"] == *kind) => {
                self.console.push(parameters["args"].to_string());
            }
            Some("Runtime.exceptionThrown") => self.console.push(parameters["exceptionDetails"].to_string()),
            Some("Log.entryAdded") if parameters["entry"]["level"] == "error" => {
                self.console.push(parameters["entry"].to_string());
            }
            _ => {}
        }
    }

    /// What the body of an asynchronous function returns.
    ///
    /// # Panics
    /// It throws.
    pub fn run(&mut self, body: &str) -> Value {
        let expression = format!("(async () => {{ {body} }})()");
        let parameters =
            json!({ "expression": expression, "awaitPromise": true, "returnByValue": true, "userGesture": true });
        let answer = self.call("Runtime.evaluate", &parameters);
        assert!(answer.get("exceptionDetails").is_none(), "{body}: {}", answer["exceptionDetails"]);
        answer["result"]["value"].clone()
    }

    /// Waits until an expression holds.
    ///
    /// # Panics
    /// It does not in good time.
    pub fn until(&mut self, expression: &str) {
        let begin = Instant::now();
        while self.run(&format!("try {{ return Boolean({expression}); }} catch {{ return false; }}")) != json!(true) {
            let late = begin.elapsed() > PATIENCE;
            assert!(!late, "{expression} never was; the page says {:?} {:?}", self.problem(), self.console);
            thread::sleep(Duration::from_millis(50));
        }
    }

    fn problem(&mut self) -> Value {
        self.run(
            "const said = ['problem', 'status'].map((id) => document.getElementById(id)?.textContent);
             return said[0] === undefined ? document.body.innerText.slice(0, 500) : said.join(' / ');",
        )
    }

    /// Moves the pointer to the first of these places of an element, shares of its width and height, presses it there, moves it over the
    /// others, and lets go at the last. Where the element is is looked up for each of them: a page may move it meanwhile.
    pub fn drag(&mut self, element: &str, places: &[[f64; 2]]) {
        let mut mouse = |kind: &str, place: [f64; 2], buttons: u32| {
            let [x, y] = self.place_on(element, place);
            let event = json!({ "type": kind, "x": x, "y": y, "button": "left", "buttons": buttons, "clickCount": 1 });
            self.call("Input.dispatchMouseEvent", &event);
        };
        let [Some(first), Some(last)] = [places.first(), places.last()] else { return };
        mouse("mouseMoved", *first, 0);
        mouse("mousePressed", *first, 1);
        places[1..].iter().for_each(|place| mouse("mouseMoved", *place, 1));
        mouse("mouseReleased", *last, 0);
    }

    /// Where a place of an element is in the window.
    fn place_on(&mut self, element: &str, [x, y]: [f64; 2]) -> [f64; 2] {
        let place = self.run(&format!(
            "const box = document.getElementById('{element}').getBoundingClientRect();
             return [box.x + {x} * box.width, box.y + {y} * box.height];"
        ));
        [0, 1].map(|axis| place[axis].as_f64().expect("a number"))
    }

    /// Gives a file input these files, as if the user had chosen them.
    pub fn choose_files(&mut self, selector: &str, files: &[PathBuf]) {
        let document = self.call("DOM.getDocument", &json!({}));
        let query = json!({ "nodeId": document["root"]["nodeId"], "selector": selector });
        let node = self.call("DOM.querySelector", &query);
        self.call("DOM.setFileInputFiles", &json!({ "files": files, "nodeId": node["nodeId"] }));
    }

    /// Writes a picture of the window, PNG.
    pub fn picture(&mut self, file: &Path) {
        let picture = self.call("Page.captureScreenshot", &json!({ "format": "png" }));
        let bytes = base64(picture["data"].as_str().expect("a picture"));
        fs::File::create(file).and_then(|mut output| output.write_all(&bytes)).expect("the picture can be written");
    }
}

impl Drop for Page {
    fn drop(&mut self) {
        let _ = self.browser.kill();
        let _ = self.browser.wait();
    }
}

/// The bytes of a text in base 64.
fn base64(text: &str) -> Vec<u8> {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let digits = text.bytes().filter_map(|byte| DIGITS.iter().position(|digit| *digit == byte));
    let mut bytes = Vec::with_capacity(text.len() * 3 / 4);
    let (mut bits, mut value) = (0, 0_u32);
    for digit in digits {
        value = value << 6 | digit as u32;
        bits += 6;
        if bits >= 8 {
            bits -= 8;
            bytes.push((value >> bits) as u8);
            value &= (1 << bits) - 1;
        }
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base_64_is_read() {
        assert_eq!(base64("aGVsbG8="), b"hello");
        assert_eq!(base64("aGVsbG8h"), b"hello!");
    }
}
