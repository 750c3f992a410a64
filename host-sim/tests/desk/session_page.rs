//! The page of a session in a real browser: it shows the arm, stops it, and says when it is no longer connected.

use crate::browser::{Browser, WEBGL};
use crate::drive::scene;
use crate::pages::WINDOWS;
use crate::session_socket::{Session, raised, state, until};
use robot_compiler::SceneFile;
use serde_json::Value;
use sim::run::scene_world;
use std::net::{TcpListener, TcpStream};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// A number of the page.
fn number(browser: &mut Browser, expression: &str) -> f64 {
    browser.value(expression).as_f64().unwrap_or_else(|| panic!("{expression} is no number"))
}

#[test]
fn a_page_shows_the_arm_as_it_moves_stops_it_and_says_when_the_session_is_gone() {
    let Some(mut browser) = Browser::start("live", WEBGL) else { return };
    // Free again when the session asks for it.
    let port = TcpListener::bind(("127.0.0.1", 0)).unwrap().local_addr().unwrap().port();
    // Slow, so that a slow machine has seen it before it ends. Once stopped, a script's arm is held until the program gets SIGTERM.
    let script = format!("{}goto 0.4 0.6 0.8 0 0 0 20\nwait\n", raised());
    let session = Session::start_with("page", &script, &["--page", &port.to_string()]);
    let address = format!("http://127.0.0.1:{port}/");
    // The session is found before its page is served.
    let begun = Instant::now();
    while TcpStream::connect(("127.0.0.1", port)).is_err() {
        assert!(begun.elapsed().as_secs() < 20, "no page");
        sleep(Duration::from_millis(5));
    }
    browser.open_address(&address, 1280, 800);
    browser.until("document.getElementById('live')?.dataset.ready === 'yes'");
    assert_eq!(browser.value("document.getElementById('live').dataset.webgl"), "yes");
    let mut client = session.client();
    until(&mut client, "it is raised", |state| state.q.get(1).is_some_and(|q| (q - 0.6).abs() < 0.003));
    browser.until("document.querySelector('.state').textContent.includes('running')");
    // States come about thirty times a second.
    let ticks = "Number(document.getElementById('live').dataset.tick)";
    let (before, begun) = (number(&mut browser, ticks), Instant::now());
    browser.until(&format!("{ticks} > {}", before + 30.0));
    assert!(begun.elapsed().as_secs_f64() < 3.0, "30 ticks of 10 ms took {:?}", begun.elapsed());
    draws_the_arm_where_it_is(&mut browser, &mut client);
    until(&mut client, "it moves", |state| state.q[0] > 0.05);
    browser.press("Escape");
    browser.until("document.querySelector('[role=alert]').textContent.startsWith('stop: confirmed: ')");
    let held = state(&mut client);
    assert!(held.state == "holding" && held.q[0] < 0.35, "{held:?}");
    browser.until("document.getElementById('live').dataset.state === 'holding'");
    for (width, height) in WINDOWS {
        for dark in [false, true] {
            browser.prefer_dark(dark);
            browser.open_address(&address, width, height);
            browser.until("document.getElementById('live').dataset.tick > 0");
            let wide = browser.beyond();
            assert!(wide <= 0.0, "{wide} pixels wider than {width}");
        }
    }
    session.signal("-TERM");
    let (code, out) = session.end();
    assert!(code == 130 && out.contains(&format!("page: {address}")), "{code}: {out}");
    browser.until("document.querySelector('.state').textContent.startsWith('NO CONNECTION')");
    browser.press("Escape");
    browser.until("document.querySelector('[role=alert]').textContent.includes('NOT CONFIRMED')");
    // Its own server is asked, and after the end nobody answers.
    let others: Vec<_> =
        browser.complaints().into_iter().filter(|text| !text.contains(&address) && !text.contains("ERR_")).collect();
    assert_eq!(others, [""; 0]);
}

fn draws_the_arm_where_it_is(browser: &mut Browser, client: &mut board::session::local::client::Client) {
    let scene = SceneFile::load(&scene("page_arm")).unwrap();
    let arm = scene_world::arm::<6>(&scene).unwrap();
    let found: Value = browser.value("tipOfRun()");
    let q: [f64; 6] = state(client).q.try_into().unwrap();
    let expected = arm.tip_pose(&q).1;
    for axis in 0..3 {
        let off = found[axis].as_f64().unwrap() - expected[axis];
        // It is held meanwhile, to some milliradians.
        assert!(off.abs() < 5e-3, "{found} {expected}");
    }
}
