//! Simulate: homes drawn, robots meddled with, floors swept, scenes shared.

use serde_json::json;
use tests::devtools::Page;

use super::{assert_sound, open, picture, scratch};

#[test]
#[ignore = "needs the built page: cargo xtask test studio"]
fn a_home_is_drawn_moved_and_typed_while_the_robot_drives() {
    let Some((mut page, address)) = open("draw", "", [1280, 900]) else { return };
    page.run(
        "document.querySelector(\"[data-tool='wall']\").click(); document.getElementById('map').scrollIntoView();",
    );
    let before = page.run("return document.getElementById('plan-text').value;");
    page.drag("map", &[[0.5, 0.75], [0.55, 0.75], [0.65, 0.75]]);
    let after = page.run("return document.getElementById('plan-text').value;");
    let added = after.as_str().unwrap().strip_prefix(before.as_str().unwrap().trim_end()).unwrap();
    assert!(added.contains("[[wall]]") && added.contains("from_m") && added.contains("to_m"), "{added}");
    picture(&mut page, "draw");
    // The wall is where it was drawn: it can be taken hold of there, moved, and erased.
    page.run("document.querySelector(\"[data-tool='move']\").click();");
    page.drag("map", &[[0.55, 0.75], [0.55, 0.7], [0.55, 0.65]]);
    let moved = page.run("return document.getElementById('plan-text').value;");
    assert!(moved != after && moved.as_str().unwrap().matches("[[wall]]").count() == 1, "{moved}");
    page.run("document.querySelector(\"[data-tool='erase']\").click();");
    page.drag("map", &[[0.6, 0.65]; 2]);
    let erased = page.run("return document.getElementById('plan-text').value;");
    assert!(!erased.as_str().unwrap().contains("[[wall]]"), "{moved}");
    // Typed, with a mistake, and without.
    let apply = |text: &str| {
        format!(
            "const text = document.getElementById('plan-text');
             text.value += {text:?};
             document.getElementById('apply-plan').click();
             return document.getElementById('problem').textContent;"
        )
    };
    let problem = page.run(&apply("\n[[round]]\ncentre_m = [2.0, 2.0]\nradius_m = -1.0\n"));
    assert!(
        problem.as_str().unwrap().contains("radius_m: is -1") && problem.as_str().unwrap().starts_with("plan:"),
        "{problem}"
    );
    page.run("document.getElementById('plan-text').value = document.getElementById('plan-text').value.replace('-1.0', '0.2');");
    assert_eq!(page.run(&apply("")), json!(""));
    assert_sound(&mut page, &address);
}

#[test]
#[ignore = "needs the built page: cargo xtask test studio"]
fn a_robot_is_carried_off_and_finds_itself_again() {
    let Some((mut page, address)) = open("carry", "", [1280, 900]) else { return };
    page.run("document.querySelector(\"[data-speed='100']\").click();");
    page.until("Number(document.getElementById('time').max) > 5000");
    page.run("document.querySelector(\"[data-speed='10']\").click(); document.getElementById('carry').click();");
    page.until("document.getElementById('status').textContent.includes('Searching')");
    picture(&mut page, "searching");
    page.run("document.querySelector(\"[data-speed='3']\").click();");
    page.until("document.getElementById('status').textContent.includes('It may be at') && (document.getElementById('play').click(), true)");
    page.run("await new Promise((done) => setTimeout(done, 1200));");
    picture(&mut page, "places");
    page.run("document.getElementById('play').click();");
    page.run("document.querySelector(\"[data-speed='100']\").click();");
    page.until("document.getElementById('status').textContent.includes('Located.')");
    picture(&mut page, "located");
    page.run(
        "for (const id of ['kick', 'hold']) document.getElementById(id).click();
        const cover = document.getElementById('cover'); cover.value = '2'; cover.dispatchEvent(new Event('change'));",
    );
    page.run("document.getElementById('cut-power').click();");
    page.until("document.getElementById('eyebrow').textContent.includes('power was cut')");
    // The map goes out as a file, and another robot begins with it, not knowing where; half of it is refused.
    page.run("document.getElementById('save-map').click();");
    let map = page.run("return [...new Uint8Array(await window.saved.arrayBuffer())];");
    let map: Vec<u8> = serde_json::from_value(map).expect("bytes");
    let [whole, half] = ["whole.bin", "half.bin"].map(|name| scratch("carry").join(name));
    std::fs::write(&whole, &map).expect("a file");
    std::fs::write(&half, &map[..map.len() / 2]).expect("a file");
    page.run("document.getElementById('seed').value = '9'; document.getElementById('again').click();");
    page.until("document.getElementById('status').textContent.startsWith('Located.')");
    page.choose_files("#give-map", &[half]);
    page.until("!document.getElementById('problem').hidden");
    page.choose_files("#give-map", &[whole]);
    page.until("document.getElementById('eyebrow').textContent.endsWith('begun anew with whole.bin')");
    page.until("document.getElementById('status').textContent.includes('Located.')");
    assert_sound(&mut page, &address);
}

#[test]
#[ignore = "needs the built page: cargo xtask test studio"]
fn a_scene_is_shared_as_a_link_and_a_bad_link_is_said() {
    let Some((mut page, address)) = open("share", "", [1280, 900]) else { return };
    let hash = page.run(
        "document.getElementById('seed').value = '7';
         const knob = document.getElementById('knob-sensors');
         knob.value = '4';
         knob.dispatchEvent(new Event('change'));
         document.getElementById('share').click();
         while (!location.hash) await new Promise((done) => setTimeout(done, 20));
         return location.hash;",
    );
    assert_sound(&mut page, &address);
    let Some((mut other, address)) = open("shared", hash.as_str().unwrap(), [1280, 900]) else { return };
    let seen = other
        .run("return [document.getElementById('seed').value, document.querySelectorAll('#trace tbody tr').length];");
    assert_eq!(seen, json!(["7", 4]));
    assert_sound(&mut other, &address);
    let Some((mut bad, address)) = open("bad-link", "#scene=%%%", [1280, 900]) else { return };
    assert!(
        bad.run("return document.getElementById('problem').textContent;").as_str().unwrap().contains("cannot be read")
    );
    assert_sound(&mut bad, &address);
}

/// The drive waits: nothing on the page moves between the look at it and the pointer.
fn pause(page: &mut Page) {
    page.run(
        "const play = document.getElementById('play'); if (play.getAttribute('aria-pressed') === 'true') play.click();",
    );
}

/// A drive that cleans the room begins.
fn clean_the_room(page: &mut Page) {
    page.run(
        "const job = document.getElementById('job'); job.value = 'clean';
         document.getElementById('plan').value = 'room';
         document.getElementById('plan').dispatchEvent(new Event('change'));",
    );
}

#[test]
#[ignore = "needs the built page: cargo xtask test studio"]
fn an_area_to_stay_out_of_is_drawn_and_the_rest_is_swept() {
    let Some((mut page, address)) = open("keep-out", "", [1280, 900]) else { return };
    clean_the_room(&mut page);
    page.run(
        "document.querySelector(\"[data-tool='keep_out']\").click(); document.getElementById('map').scrollIntoView();",
    );
    page.until("document.getElementById('play').getAttribute('aria-pressed') === 'true'");
    pause(&mut page);
    let share =
        "return Number(document.getElementById('status').textContent.match(/([0-9.]+) % of the floor/)?.[1] ?? -1);";
    page.drag("map", &[[0.55, 0.3], [0.6, 0.4], [0.68, 0.52]]);
    let text = page.run("return document.getElementById('plan-text').value;");
    assert!(text.as_str().unwrap().contains("[[keep_out]]\npoints_m = [["), "{text}");
    assert_eq!(page.run("return document.getElementById('problem').textContent;"), json!(""));
    page.run("document.querySelector(\"[data-speed='100']\").click(); document.getElementById('play').click();");
    page.until("document.getElementById('status').textContent.includes('it is back where it started')");
    picture(&mut page, "keep-out");
    let swept = page.run(share).as_f64().expect("a share");
    assert!(swept > 90.0, "what is out of bounds does not count as floor: {swept} %");
    // It is taken hold of by its edge, which lies within a decimetre of where it was drawn: the map turned about the start meanwhile.
    pause(&mut page);
    page.run("document.querySelector(\"[data-tool='erase']\").click();");
    let is_gone = (26..=34).any(|percent| {
        page.drag("map", &[[0.6, 0.01 * f64::from(percent)]; 2]);
        let rest = page.run("return document.getElementById('plan-text').value;");
        !rest.as_str().unwrap().contains("[[keep_out]]")
    });
    assert!(is_gone, "an area that is clicked on goes");
    assert_sound(&mut page, &address);
}

#[test]
#[ignore = "needs the built page: cargo xtask test studio"]
fn a_floor_is_swept_and_shown_as_it_was_at_each_moment() {
    let Some((mut page, address)) = open("clean", "", [1280, 900]) else { return };
    clean_the_room(&mut page);
    page.run("document.querySelector(\"[data-speed='100']\").click();");
    page.until("/Sweeping: (edges|lanes)/.test(document.getElementById('status').textContent)");
    page.until("Number(document.getElementById('time').max) > 2500");
    picture(&mut page, "clean");
    page.until("document.getElementById('status').textContent.includes('it is back where it started')");
    let said = page.run("return document.getElementById('status').textContent;");
    let swept: f64 = said
        .as_str()
        .and_then(|said| said.split_once(" % of the floor")?.0.rsplit(' ').next()?.parse().ok())
        .expect("a share");
    assert!(swept > 90.0, "{said}");
    picture(&mut page, "clean-done");
    // At the end more of the map is tinted than at its beginning, which is shown as it was.
    page.run("document.querySelectorAll('[data-layer]').forEach((box) => box.dataset.layer !== 'floor' && box.checked && box.click());");
    let tinted = "const map = document.getElementById('map');
        const data = map.getContext('2d').getImageData(0, 0, map.width, map.height).data;
        let count = 0;
        for (let i = 0; i < data.length; i += 4) count += data[i + 3] > 0 && data[i + 1] > data[i] + 15;
        return count;";
    let at = |step: &str| {
        format!("const slider = document.getElementById('time'); slider.value = {step}; slider.dispatchEvent(new Event('input'));
        await new Promise((done) => setTimeout(done, 400));")
    };
    page.run(&at("'250'"));
    let early = page.run(tinted).as_u64().expect("a count");
    page.run(&at("slider.max"));
    let late = page.run(tinted).as_u64().expect("a count");
    assert!(early > 0 && late > 3 * early, "{early} {late}");
    assert_sound(&mut page, &address);
}

#[test]
#[ignore = "needs the built page: cargo xtask test studio"]
fn a_drive_is_looked_back_on_while_it_goes_on() {
    let Some((mut page, address)) = open("look-back", "", [1280, 900]) else { return };
    page.run("document.querySelector(\"[data-speed='100']\").click();");
    page.until("Number(document.getElementById('time').max) > 3000");
    page.run("document.querySelector(\"[data-speed='1']\").click(); document.getElementById('look-back').click();");
    page.until("document.getElementById('status').textContent.includes('The look back placed the first')");
    assert_eq!(page.run("return document.getElementById('play').textContent;"), json!("Pause"), "the drive goes on");
    picture(&mut page, "look-back");
    // Its page is of the whole drive, which waits for it.
    page.run("document.getElementById('save-look-back').click();");
    page.until("window.saved !== null");
    let saved = page.run("return await window.saved.text();");
    assert!(saved.as_str().unwrap().contains("looking back"), "another page was saved");
    // Who was carried off has no drive in one frame.
    page.run("document.getElementById('carry').click();");
    page.until("document.getElementById('status').textContent.includes('No look back: the robot lost its place')");
    assert_sound(&mut page, &address);
}
