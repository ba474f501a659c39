//! The studio as a user meets it, in a browser. `cargo xtask test studio` builds the page first and names its folder.

mod replay;
mod robot;
mod simulate;

use std::path::{Path, PathBuf};

use serde_json::json;
use tests::browser::Browser;
use tests::devtools::{Page, serve};

/// Names the page's folder.
const VARIABLE: &str = "STUDIO_PAGE";

fn page_folder() -> PathBuf {
    std::env::var_os(VARIABLE)
        .map_or_else(|| panic!("{VARIABLE} must name the folder that `cargo xtask studio` prints"), PathBuf::from)
}

fn scratch(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join("studio").join(name)
}

/// Where a monitor on this machine lets pages take part in a robot's line.
const RELAY: &str = "ws://127.0.0.1:";

/// Opens the studio; `hash` goes behind its address.
fn open(name: &str, hash: &str, size: [u32; 2]) -> Option<(Page, String)> {
    open_with(name, hash, size, "")
}

/// The same, after a script of ours.
fn open_with(name: &str, hash: &str, size: [u32; 2], first: &str) -> Option<(Page, String)> {
    let browser = Browser::find()?;
    let address = serve(&page_folder());
    // What the page saves is kept for the test.
    let first = format!(
        "{first}; window.saved = null;
         const make = URL.createObjectURL.bind(URL);
         URL.createObjectURL = (blob) => {{ window.saved = blob; return make(blob); }};"
    );
    let mut page = Page::open(&browser, &scratch(name), &format!("{address}{hash}"), size, &first);
    page.until("document.documentElement.dataset.ready === 'true'");
    Some((page, address))
}

/// No fault, no console message, no request to elsewhere; nothing that reads as a missing number.
fn assert_sound(page: &mut Page, address: &str) {
    assert_eq!(page.run("return document.documentElement.dataset.errors;"), json!("0"), "{:#?}", page.console);
    assert!(page.console.is_empty(), "{:#?}", page.console);
    let outside: Vec<&String> =
        page.requests.iter().filter(|request| !request.starts_with(address) && !request.starts_with(RELAY)).collect();
    assert!(outside.is_empty() && page.requests.len() >= 4, "{:?}", page.requests);
    let odd = page.run("return /NaN|undefined|null|Infinity/.test(document.querySelector('main').innerText);");
    assert_eq!(odd, json!(false));
    let unnamed = page.run(
        "return [...document.querySelectorAll('button, input, canvas, select, textarea')].filter((node) =>
            !(node.getAttribute('aria-label') || node.getAttribute('aria-hidden') || node.labels?.length || node.textContent.trim()))
            .map((node) => node.outerHTML);",
    );
    assert_eq!(unnamed, json!([]), "controls without a name");
}

fn picture(page: &mut Page, name: &str) {
    page.picture(&scratch(&format!("{name}.png")));
}

#[test]
#[ignore = "needs the built page: cargo xtask test studio"]
fn the_first_visit_shows_a_home_being_mapped_without_a_click() {
    let Some((mut page, address)) = open("first", "", [1280, 900]) else { return };
    page.until("document.querySelectorAll('#walls tbody tr').length > 5");
    let seen = page.run(
        "const text = (id) => document.getElementById(id).textContent;
         return { title: text('title'), verdict: text('verdict'), play: text('play'),
            charts: [...document.querySelectorAll('[data-chart]')].map((chart) => chart.dataset.chart),
            wide: document.documentElement.scrollWidth - innerWidth };",
    );
    assert_eq!((&seen["title"], &seen["play"]), (&json!("flat"), &json!("Pause")), "{seen}");
    assert!(seen["verdict"].as_str().unwrap().contains("walls in the map"), "{seen}");
    assert!(seen["wide"].as_i64().unwrap() <= 0, "the page scrolls sideways");
    picture(&mut page, "first");
    page.run("scrollTo(0, 1100); await new Promise((done) => setTimeout(done, 1500));");
    picture(&mut page, "first-below");
    page.run("scrollTo(0, 2200); await new Promise((done) => setTimeout(done, 1500));");
    picture(&mut page, "first-far-below");
    assert_sound(&mut page, &address);
}

#[test]
#[ignore = "needs the built page: cargo xtask test studio"]
fn a_drive_pauses_goes_faster_and_can_be_looked_back_on() {
    let Some((mut page, address)) = open("transport", "", [1280, 900]) else { return };
    page.run("document.querySelector(\"[data-speed='100']\").click();");
    page.until("Number(document.getElementById('time').max) > 1500");
    let seen = page.run(
        "const clock = () => document.getElementById('clock').textContent;
         document.getElementById('play').click();
         const paused = clock();
         await new Promise((done) => setTimeout(done, 300));
         const later = clock();
         const slider = document.getElementById('time');
         slider.value = '100';
         slider.dispatchEvent(new Event('input'));
         const back = clock();
         document.getElementById('follow-now').click();
         return { paused, later, back, end: clock(), hidden: document.getElementById('follow-now').hidden };",
    );
    assert_eq!(seen["paused"], seen["later"]);
    assert!(seen["back"].as_str().unwrap().starts_with("0:04.0 / "), "{seen}");
    // The drive may be a sample ahead of what was shown as it paused; following goes to its newest moment.
    let newest = seen["paused"].as_str().and_then(|clock| clock.split_once(" / ")).map(|(_, newest)| newest).unwrap();
    assert_eq!((&seen["end"], &seen["hidden"]), (&json!(format!("{newest} / {newest}")), &json!(true)));
    page.run(
        "const plan = document.getElementById('plan'); plan.value = 'room'; plan.dispatchEvent(new Event('change'));",
    );
    page.until(
        "document.getElementById('title').textContent === 'room' && Number(document.getElementById('time').max) > 100",
    );
    assert_sound(&mut page, &address);
}

#[test]
#[ignore = "needs the built page: cargo xtask test studio"]
fn a_phone_shows_it_without_scrolling_sideways() {
    let Some((mut page, address)) = open("phone", "", [390, 840]) else { return };
    page.until("document.querySelectorAll('#walls tbody tr').length > 3");
    assert!(page.run("return document.documentElement.scrollWidth - innerWidth;").as_i64().unwrap() <= 0);
    picture(&mut page, "phone");
    assert_sound(&mut page, &address);
}
