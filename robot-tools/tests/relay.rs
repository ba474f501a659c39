//! A robot's line shared with a page.
#![cfg(unix)]

use std::io::{Read, Write};
use std::os::unix::net::UnixStream;

use robot_tools::relay::relay;
use tungstenite::client::IntoClientRequest;
use tungstenite::{Message, connect};

#[test]
fn a_page_hears_the_robot_and_steers_it_and_a_strange_page_does_not() {
    let (mut robot, line) = UnixStream::pair().unwrap();
    let line = (Box::new(line.try_clone().unwrap()) as Box<dyn Read + Send>, Box::new(line) as Box<dyn Write + Send>);
    let ((mut heard, mut steered), address) = relay(line, "127.0.0.1:0", None).unwrap();
    let (mut page, _) = connect(format!("ws://{address}")).unwrap();
    // What the page says first shows that it is admitted.
    page.send(Message::binary(vec![1, 2, 3])).unwrap();
    let mut bytes = [0; 3];
    robot.read_exact(&mut bytes).unwrap();
    assert_eq!(bytes, [1, 2, 3]);
    robot.write_all(b"frames").unwrap();
    let mut own = [0; 16];
    let count = heard.read(&mut own).unwrap();
    assert_eq!(&own[..count], b"frames");
    assert_eq!(page.read().unwrap().into_data().as_ref(), b"frames");
    steered.write_all(&[9]).unwrap();
    robot.read_exact(&mut bytes[..1]).unwrap();
    assert_eq!(bytes[0], 9);
    let mut strange = format!("ws://{address}").into_client_request().unwrap();
    strange.headers_mut().insert("origin", "https://example.org".parse().unwrap());
    assert!(connect(strange).is_err());
    // A page that is gone does not stop the line.
    drop(page);
    for _ in 0..600 {
        robot.write_all(b"x").unwrap();
        assert!(heard.read(&mut own).unwrap() > 0);
    }
}
