//! How soon the studio shows a map, how many frames a second it draws, and how fast it drives: `cargo xtask studio --measure`.

use std::path::Path;
use std::time::Instant;

use tests::browser::Browser;
use tests::devtools::{Page, serve};

/// How long each speed is watched, seconds.
const WATCHED_S: f64 = 10.0;

fn main() {
    let folder = std::env::var("STUDIO_PAGE").expect("STUDIO_PAGE names the page's folder");
    let browser = Browser::find().expect("a browser");
    let profile = std::env::temp_dir().join("studio-speed");
    let begin = Instant::now();
    let mut page = Page::open(&browser, &profile, &serve(Path::new(&folder)), [1280, 900], "");
    page.until("document.querySelectorAll('#walls tbody tr').length > 0");
    let since_load = page.run("return performance.now();").as_f64().unwrap_or(f64::NAN);
    println!(
        "first walls on the page {:.1} s after the page began to load, {:.1} s after the browser was started",
        since_load / 1000.0,
        begin.elapsed().as_secs_f64()
    );
    for speed in [1, 10, 100] {
        page.run(&format!("document.querySelector(\"[data-speed='{speed}']\").click();"));
        let seen = page.run(&format!(
            "const seconds = () => document.getElementById('clock').textContent.split('/ ')[1].split(':')
                 .reduce((all, part) => 60 * all + Number(part), 0);
             const [begin, from] = [performance.now(), seconds()];
             const gaps = [];
             let last = begin;
             await new Promise((done) => {{
                 const frame = (now) => {{
                     gaps.push(now - last);
                     last = now;
                     if (now - begin < {WATCHED_S} * 1000) requestAnimationFrame(frame);
                     else done();
                 }};
                 requestAnimationFrame(frame);
             }});
             const span = (performance.now() - begin) / 1000;
             gaps.sort((a, b) => a - b);
             return [gaps.length / span, gaps[Math.floor(0.95 * gaps.length)], (seconds() - from) / span];"
        ));
        let number = |i: usize| seen[i].as_f64().unwrap_or(f64::NAN);
        println!(
            "at {speed}x: {:.0} frames a second, 95 % of frames within {:.0} ms, {:.1} times real time",
            number(0),
            number(1),
            number(2)
        );
    }
}
