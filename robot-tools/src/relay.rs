//! A robot's line for browsers: its bytes go to every page that asks, and what a page sends goes to the robot.
//!
//! Bytes are passed on as they are; the page finds the frames in them as this program does.

use std::io::{self, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use tungstenite::handshake::server::{ErrorResponse, Request, Response};
use tungstenite::http::StatusCode;
use tungstenite::protocol::WebSocketConfig;
use tungstenite::{Error, Message, WebSocket};

use crate::port::Line;

/// Pieces of the line that wait for a page; one that is further behind is left.
const WAITING: usize = 256;
/// How long a page is listened to before what came for it is sent.
const TURN: Duration = Duration::from_millis(10);
/// Longest message of a page, bytes: a command has twenty.
const LONGEST: usize = 4096;
/// Most pages at once.
const MOST_PAGES: usize = 8;

type Pages = Arc<Mutex<Vec<SyncSender<Arc<[u8]>>>>>;
type Robot = Arc<Mutex<Box<dyn Write + Send>>>;

/// Lets pages take part in a line at this address, for instance `127.0.0.1:8091`; `allowed` is the origin of pages that come
/// from elsewhere than this machine, for instance `https://example.org`.
///
/// # Errors
/// Nobody can listen at the address.
pub fn relay((from, to): Line, address: &str, allowed: Option<&str>) -> Result<(Line, std::net::SocketAddr), String> {
    let failed = |error: io::Error| format!("{address}: {error}; name a free address of this machine with --serve");
    let listener = TcpListener::bind(address).map_err(failed)?;
    let bound = listener.local_addr().map_err(failed)?;
    let (pages, robot): (Pages, Robot) = (Arc::default(), Arc::new(Mutex::new(to)));
    let (listened, steered, allowed) = (Arc::clone(&pages), Arc::clone(&robot), allowed.map(str::to_owned));
    thread::spawn(move || {
        for stream in listener.incoming().filter_map(Result::ok) {
            let (pages, robot, allowed) = (Arc::clone(&listened), Arc::clone(&steered), allowed.clone());
            // What one page does wrong is no concern of the others.
            thread::spawn(move || admit(stream, &pages, &robot, allowed.as_deref()));
        }
    });
    let line: Line = (Box::new(Heard { from, pages }), Box::new(Steered(robot)));
    Ok((line, bound))
}

/// The robot's side, heard by pages as well.
struct Heard {
    from: Box<dyn Read + Send>,
    pages: Pages,
}

impl Read for Heard {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.from.read(buffer)?;
        let piece: Arc<[u8]> = buffer[..count].into();
        let mut pages = self.pages.lock().unwrap_or_else(PoisonError::into_inner);
        // A page that is behind or gone must not stop the robot's line.
        pages.retain(|page| {
            !matches!(page.try_send(Arc::clone(&piece)), Err(TrySendError::Full(_) | TrySendError::Disconnected(_)))
        });
        Ok(count)
    }
}

/// The way to the robot, shared: each write is whole.
struct Steered(Robot);

impl Write for Steered {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).flush()
    }
}

fn admit(stream: TcpStream, pages: &Pages, robot: &Robot, allowed: Option<&str>) -> Result<(), Error> {
    stream.set_read_timeout(Some(Duration::from_secs(5)))?;
    let config = WebSocketConfig::default().max_message_size(Some(LONGEST)).max_frame_size(Some(LONGEST));
    #[expect(clippy::result_large_err, reason = "the library's callback returns this")]
    let check = |request: &Request, response: Response| {
        let origin = request.headers().get("origin").map(|origin| origin.to_str().unwrap_or_default());
        if origin.is_none_or(|origin| is_local(origin) || Some(origin) == allowed) {
            return Ok(response);
        }
        let mut refused =
            ErrorResponse::new(Some("a page of this origin may not steer the robot; see --allow".to_owned()));
        *refused.status_mut() = StatusCode::FORBIDDEN;
        Err(refused)
    };
    let socket = tungstenite::accept_hdr_with_config(stream, check, Some(config));
    let Ok(socket) = socket else { return Ok(()) };
    let (page, pieces) = sync_channel(WAITING);
    {
        let mut pages = pages.lock().unwrap_or_else(PoisonError::into_inner);
        if pages.len() >= MOST_PAGES {
            return Ok(());
        }
        pages.push(page);
    }
    socket.get_ref().set_read_timeout(Some(TURN))?;
    attend(socket, &pieces, robot)
}

/// Listens and sends in turns until the page is gone.
fn attend(mut socket: WebSocket<TcpStream>, pieces: &Receiver<Arc<[u8]>>, robot: &Robot) -> Result<(), Error> {
    loop {
        match socket.read() {
            Ok(Message::Binary(bytes)) => {
                let mut robot = robot.lock().unwrap_or_else(PoisonError::into_inner);
                robot.write_all(&bytes).and_then(|()| robot.flush())?;
            }
            Ok(_) => {}
            Err(Error::Io(error)) if matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut) => {}
            Err(error) => return Err(error),
        }
        loop {
            match pieces.try_recv() {
                Ok(piece) => socket.send(Message::binary(piece.to_vec()))?,
                Err(std::sync::mpsc::TryRecvError::Empty) => break,
                Err(std::sync::mpsc::TryRecvError::Disconnected) => return Ok(()),
            }
        }
    }
}

/// Whether a page comes from this machine: any page of the web could ask a browser to connect here otherwise.
fn is_local(origin: &str) -> bool {
    let host = origin.split_once("://").map_or(origin, |(_, rest)| rest);
    let host = if host.starts_with('[') { host } else { host.split(':').next().unwrap_or_default() };
    ["localhost", "127.0.0.1"].contains(&host) || host.starts_with("[::1]")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pages_from_elsewhere_are_not_local() {
        for local in ["http://localhost:8090", "http://127.0.0.1", "http://[::1]:8090"] {
            assert!(is_local(local), "{local}");
        }
        for other in ["https://example.org", "http://localhost.example.org", "null", "http://127.0.0.1.example.org:80"]
        {
            assert!(!is_local(other), "{other}");
        }
    }
}
