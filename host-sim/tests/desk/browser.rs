//! A headless Chromium, controlled by its DevTools protocol over a pipe: JSON messages, each ended by a zero byte.

use serde_json::{Value, json};
use std::io::{BufRead as _, BufReader, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// A browser with one page. It ends on drop.
pub(crate) struct Browser {
    program: Child,
    to: ChildStdin,
    from: BufReader<ChildStdout>,
    profile: PathBuf,
    session: Option<String>,
    calls: u64,
    events: Vec<Value>,
}

/// No background activity, no network, WebGL in software.
const OPTIONS: [&str; 10] = [
    "--headless=new",
    "--no-sandbox",
    "--remote-debugging-pipe",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-first-run",
    "--hide-scrollbars",
    "--use-gl=angle",
    "about:blank",
];

/// Options for a browser with WebGL, and for one without.
pub(crate) const WEBGL: [&str; 2] = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader"];
pub(crate) const FLAT: [&str; 2] = ["--disable-gpu", "--disable-3d-apis"];

/// Longest wait for the page.
const PATIENCE: Duration = Duration::from_secs(30);

impl Browser {
    /// Starts the browser with an empty profile of this name. Without Chromium, returns `None` and prints a note; in continuous integration, that is
    /// a failure.
    pub(crate) fn start(name: &str, options: [&str; 2]) -> Option<Self> {
        let paths = std::env::var_os("PATH").unwrap_or_default();
        if !std::env::split_paths(&paths).any(|folder| folder.join("chromium").is_file()) {
            let required =
                ["CI", "NEWTAU_CI"].iter().any(|name| std::env::var_os(name).is_some_and(|value| !value.is_empty()));
            assert!(!required, "no chromium here: apt-get install chromium");
            eprintln!("skipped: no chromium here (cargo xtask setup installs it)");
            return None;
        }
        let profile = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("chromium-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&profile).unwrap();
        // The browser uses the descriptors 3 and 4, which are connected to our pipes.
        let mut command = Command::new("sh");
        command.args(["-c", "exec chromium \"$@\" 3<&0 4>&1 </dev/null >/dev/null 2>/dev/null", "chromium"]);
        command.args(options).arg(format!("--user-data-dir={}", profile.display())).args(OPTIONS);
        let mut program = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
        let (to, from) = (program.stdin.take().unwrap(), BufReader::new(program.stdout.take().unwrap()));
        let mut browser = Self { program, to, from, profile, session: None, calls: 0, events: Vec::new() };
        let target = browser.call("Target.createTarget", json!({ "url": "about:blank" }));
        let attach = json!({ "targetId": target["targetId"], "flatten": true });
        browser.session = browser.call("Target.attachToTarget", attach)["sessionId"].as_str().map(str::to_owned);
        for domain in ["Page", "Runtime", "Log", "Network"] {
            browser.call(&format!("{domain}.enable"), json!({}));
        }
        Some(browser)
    }

    /// Calls a method and waits for its answer. Events in the meantime are kept.
    pub(crate) fn call(&mut self, method: &str, parameters: Value) -> Value {
        self.calls += 1;
        let mut message = json!({ "id": self.calls, "method": method, "params": parameters });
        if let Some(session) = &self.session {
            message["sessionId"] = json!(session);
        }
        self.to.write_all(format!("{message}\0").as_bytes()).unwrap();
        self.to.flush().unwrap();
        loop {
            let mut bytes = Vec::new();
            assert!(self.from.read_until(0, &mut bytes).unwrap() > 0, "the browser ended during {method}");
            bytes.pop();
            let mut answer: Value = serde_json::from_slice(&bytes).unwrap();
            if answer["id"] == self.calls {
                assert!(answer.get("error").is_none(), "{method}: {answer}");
                return answer["result"].take();
            }
            self.events.push(answer);
        }
    }

    /// Value of an expression in the page.
    pub(crate) fn value(&mut self, expression: &str) -> Value {
        let asked = json!({ "expression": expression, "awaitPromise": true, "returnByValue": true });
        let mut answer = self.call("Runtime.evaluate", asked);
        assert!(answer.get("exceptionDetails").is_none(), "{expression}: {answer}");
        answer["result"]["value"].take()
    }

    /// Waits until an expression is true.
    pub(crate) fn until(&mut self, expression: &str) {
        let start = Instant::now();
        while self.value(expression) != json!(true) {
            assert!(start.elapsed() < PATIENCE, "still not so: {expression}\n{:?}", self.complaints());
            sleep(Duration::from_millis(20));
        }
    }

    /// Opens a file at a width and height.
    pub(crate) fn open(&mut self, file: &Path, width: u32, height: u32) {
        self.open_address(&format!("file://{}", file.display()), width, height);
    }

    /// Opens a page at a width and height.
    pub(crate) fn open_address(&mut self, address: &str, width: u32, height: u32) {
        let size = json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 600 });
        self.call("Emulation.setDeviceMetricsOverride", size);
        self.call("Page.navigate", json!({ "url": "about:blank" }));
        self.call("Page.navigate", json!({ "url": address }));
        self.until("document.readyState === 'complete'");
    }

    /// Sets the user's preference for dark pages.
    pub(crate) fn prefer_dark(&mut self, dark: bool) {
        let value = if dark { "dark" } else { "light" };
        let features = json!([{ "name": "prefers-color-scheme", "value": value }]);
        self.call("Emulation.setEmulatedMedia", json!({ "features": features }));
    }

    /// Presses a key.
    pub(crate) fn press(&mut self, key: &str) {
        let text = if key.chars().count() == 1 { key } else { "" };
        let down = if text.is_empty() { "rawKeyDown" } else { "keyDown" };
        self.call("Input.dispatchKeyEvent", json!({ "type": down, "key": key, "text": text }));
        self.call("Input.dispatchKeyEvent", json!({ "type": "keyUp", "key": key }));
    }

    /// Pixels by which the page is wider than its window. `innerWidth` does not show that: on a phone it grows with the page.
    pub(crate) fn beyond(&mut self) -> f64 {
        let beyond = "document.documentElement.scrollWidth - document.documentElement.clientWidth";
        self.value(beyond).as_f64().unwrap()
    }

    /// Error messages of the pages, and their requests to the network.
    pub(crate) fn complaints(&self) -> Vec<String> {
        let said = |event: &Value| match event["method"].as_str()? {
            "Runtime.exceptionThrown" | "Runtime.consoleAPICalled" | "Log.entryAdded" => Some(event.to_string()),
            "Network.requestWillBeSent" => {
                let address = event["params"]["request"]["url"].as_str().unwrap_or_default();
                let ours = ["file:", "data:", "blob:", "about:"].iter().any(|scheme| address.starts_with(scheme));
                (!ours).then(|| format!("asked for {address}"))
            }
            _ => None,
        };
        self.events.iter().filter_map(said).collect()
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        self.program.kill().ok();
        self.program.wait().ok();
        std::fs::remove_dir_all(&self.profile).ok();
    }
}
