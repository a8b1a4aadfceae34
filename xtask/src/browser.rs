//! The pages in a real browser: nothing fetched, nothing in the console, nothing wider than a phone, keys, contrast, paper.

use crate::{Outcome, output};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Names that the browser may have.
const BROWSERS: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "chrome"];
/// A page may load nothing and say nothing to anybody.
const POLICY: &str = "<meta http-equiv=\"Content-Security-Policy\" \
                      content=\"default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'\">";
/// A phone in light, a desk in dark, a sheet of paper.
const VIEWS: [(&str, u32, bool); 3] =
    [("phone", 360, false), ("desk in the dark", 1100, true), ("paper", 718, false)];

pub fn check() -> Outcome {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().ok_or("no workspace")?;
    let browser = BROWSERS
        .into_iter()
        .find(|name| Command::new(name).arg("--version").output().is_ok_and(|out| out.status.success()))
        .ok_or("no Chromium: install the package chromium")?;
    output(
        Command::new("cargo").args(["build", "--release", "--locked", "-p", "pitchid"]).current_dir(root),
    )?;
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root.join("target"), PathBuf::from);
    let work = target.join("browser");
    fs::create_dir_all(&work).map_err(|error| error.to_string())?;
    control(browser, &work)?;
    let mut wrong = Vec::new();
    for page in pages(&target.join("release/pitchid"), &work)? {
        for (view, width, dark) in VIEWS {
            let said = asked(browser, &page, width, dark)?;
            let name = page.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            println!("{name}, {view}: {}", said.lines().next().unwrap_or_default());
            wrong.extend(said.lines().skip(1).map(|line| format!("{name}, {view}: {line}")));
        }
        let paper = page.with_extension("pdf");
        output(
            started(browser)
                .arg("--no-pdf-header-footer")
                .arg(format!("--print-to-pdf={}", paper.display()))
                .arg(&page),
        )?;
        let bytes = fs::metadata(&paper).map_err(|error| format!("{}: {error}", paper.display()))?.len();
        println!("{}: {bytes} bytes of PDF", paper.display());
    }
    if wrong.is_empty() { Ok(()) } else { Err(wrong.join("\n")) }
}

/// A page with everything wrong must be told so.
fn control(browser: &str, work: &Path) -> Outcome {
    let page = work.join("control.html");
    let body = "<html><head></head><body><img src=\"https://example.org/a.png\"><p style=\"font-size: 8px\">small</p>\
                <p style=\"color: #bbb\">pale</p><div style=\"width: 2000px\">wide</div><button></button>\
                <script>console.error('loud')</script></body></html>";
    fs::write(&page, body).map_err(|error| error.to_string())?;
    let said = asked(browser, &page, 360, false)?;
    let told =
        ["fetches https://example.org", "8 px: small", "contrast", "px wide in 360", "has no name", "loud"];
    match told.into_iter().find(|what| !said.contains(what)) {
        Some(missed) => Err(format!("a page with everything wrong is not told \"{missed}\":\n{said}")),
        None => Ok(()),
    }
}

/// Pages of every kind, made by the program.
fn pages(pitchid: &Path, work: &Path) -> Outcome<Vec<PathBuf>> {
    let run = |arguments: &[&str]| output(Command::new(pitchid).args(arguments).current_dir(work));
    run(&["demo", "--out", "demo"])?;
    let log = "demo/recording.csv";
    run(&["show", log, "--report", "show.html"])?;
    run(&["identify", log, "--report", "identified.html"])?;
    run(&["diagnose", log, "--time", "0..3", "--report", "refused.html"])?;
    run(&["diagnose", log, "--report", "without-model.html"])?;
    let names = ["demo/report.html", "show.html", "identified.html", "refused.html", "without-model.html"];
    Ok(names.into_iter().map(|name| work.join(name)).collect())
}

/// What a page says to the questions of `browser.js`: how much was asked, then what is wrong.
fn asked(browser: &str, page: &Path, width: u32, dark: bool) -> Outcome<String> {
    let text = fs::read_to_string(page).map_err(|error| format!("{}: {error}", page.display()))?;
    let questions = format!("<head>{POLICY}<script>{}</script>", include_str!("browser.js"));
    let copy = page.with_extension("asked.html");
    fs::write(&copy, text.replacen("<head>", &questions, 1)).map_err(|error| error.to_string())?;
    // a window has a least width, a frame has none
    let frame = page.with_extension("frame.html");
    let name = copy.file_name().unwrap_or_default().to_string_lossy();
    let around = format!(
        "<!DOCTYPE html><pre id=\"checked\"></pre><script>addEventListener('message', e => checked.textContent = e.data)</script>\
         <iframe src=\"{name}\" style=\"border: 0; width: {width}px; height: 900px\"></iframe>"
    );
    fs::write(&frame, around).map_err(|error| error.to_string())?;
    let mut command = started(browser);
    if dark {
        command.arg("--blink-settings=preferredColorScheme=0");
    }
    let dom = output(command.arg("--window-size=1200,1000").arg("--dump-dom").arg(&frame))?;
    let (_, rest) = dom
        .split_once("<pre id=\"checked\">CHECKED ")
        .ok_or_else(|| format!("{}: the page did not load", page.display()))?;
    let (said, _) = rest.split_once("\nEND").ok_or("the answer is cut off")?;
    Ok(said.trim_end().to_owned())
}

fn started(browser: &str) -> Command {
    let mut command = Command::new(browser);
    command.args([
        "--headless",
        "--no-sandbox",
        "--disable-gpu",
        "--hide-scrollbars",
        "--virtual-time-budget=4000",
    ]);
    command
}
