//! A server for a folder of files on this machine, for development and tests: `GET`, one request a connection.

use std::fs;
use std::io::{self, BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::thread;
use std::time::Duration;

/// Longest request head, bytes.
const LONGEST: u64 = 16 * 1024;
/// A client that says nothing for so long is left.
const PATIENCE: Duration = Duration::from_secs(10);

/// Serves the folder's files to whoever connects, until the listener fails.
///
/// # Errors
/// What the system says of the listener.
pub fn serve(listener: &TcpListener, folder: &Path) -> io::Result<()> {
    loop {
        let (stream, _) = listener.accept()?;
        let folder = folder.to_owned();
        // What one client does wrong is no concern of the next.
        thread::spawn(move || answer(&stream, &folder));
    }
}

fn answer(stream: &TcpStream, folder: &Path) -> io::Result<()> {
    stream.set_read_timeout(Some(PATIENCE))?;
    let mut lines = BufReader::new(stream.take(LONGEST)).lines();
    let request = lines.next().transpose()?.unwrap_or_default();
    // The rest of the head is read, so that the client may close.
    for line in lines {
        if line?.is_empty() {
            break;
        }
    }
    let found = path_of(&request).and_then(|path| fs::read(folder.join(&path)).ok().map(|bytes| (path, bytes)));
    let (status, kind, body) = match &found {
        Some((path, bytes)) => ("200 OK", kind_of(path), bytes.as_slice()),
        None => ("404 Not Found", "text/plain", b"not found".as_slice()),
    };
    let head = format!(
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\nCache-Control: no-store\r\nConnection: close\r\n\r\n",
        body.len()
    );
    let mut stream = stream;
    stream.write_all(head.as_bytes())?;
    stream.write_all(body)
}

/// The file that a request asks for, below the folder; none where it is no `GET` or would lead out.
fn path_of(request: &str) -> Option<PathBuf> {
    let (path, _) = request.strip_prefix("GET /")?.rsplit_once(" HTTP/")?;
    let path = path.split(['?', '#']).next().unwrap_or_default();
    let is_plain = |part: &str| {
        !part.is_empty()
            && !part.starts_with('.')
            && part.chars().all(|c| c.is_ascii_alphanumeric() || "._-".contains(c))
    };
    match path {
        "" => Some(PathBuf::from("index.html")),
        _ => path.split('/').all(is_plain).then(|| PathBuf::from(path)),
    }
}

fn kind_of(path: &Path) -> &'static str {
    match path.extension().and_then(|ending| ending.to_str()) {
        Some("html") => "text/html; charset=utf-8",
        Some("js") => "text/javascript; charset=utf-8",
        Some("css") => "text/css; charset=utf-8",
        Some("wasm") => "application/wasm",
        Some("png") => "image/png",
        _ => "application/octet-stream",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_request_leads_out_of_the_folder() {
        let path = |request| path_of(request).map(|path| path.display().to_string());
        assert_eq!(path("GET / HTTP/1.1").as_deref(), Some("index.html"));
        assert_eq!(path("GET /studio_bg.wasm?v=1 HTTP/1.1").as_deref(), Some("studio_bg.wasm"));
        for bad in
            ["GET /../secret HTTP/1.1", "GET //etc/passwd HTTP/1.1", "GET /a/../../b HTTP/1.1", "POST / HTTP/1.1", ""]
        {
            assert_eq!(path(bad), None, "{bad}");
        }
    }

    #[test]
    fn a_file_comes_with_its_kind_and_what_is_not_there_is_not_found() {
        let folder = std::env::temp_dir().join(format!("pages-serve-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        fs::write(folder.join("a.wasm"), b"1234").unwrap();
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap();
        let served = folder.clone();
        thread::spawn(move || serve(&listener, &served));
        let ask = |what: &str| {
            let mut stream = TcpStream::connect(address).unwrap();
            write!(stream, "GET /{what} HTTP/1.1\r\nHost: here\r\n\r\n").unwrap();
            let mut answer = String::new();
            stream.read_to_string(&mut answer).unwrap();
            answer
        };
        let found = ask("a.wasm");
        assert!(
            found.starts_with("HTTP/1.1 200 OK") && found.contains("application/wasm") && found.ends_with("1234"),
            "{found}"
        );
        assert!(ask("b.wasm").starts_with("HTTP/1.1 404"));
        fs::remove_dir_all(&folder).unwrap();
    }
}
