//! The pages in a real browser: nothing fetched, nothing in the console, nothing wider than a phone, keys, contrast, paper.

use crate::{Outcome, output};
use rayon::prelude::*;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Names that the browser may have.
const BROWSERS: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "chrome"];
/// A page may load nothing and say nothing to anybody.
const POLICY: &str = "<meta http-equiv=\"Content-Security-Policy\" \
                      content=\"default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'\">";
/// The checker of accessibility, a single script that is not part of any page, and its SHA-256.
const AXE: [&str; 2] =
    ["axe-core@4.14.1", "29348999450cdf2849a8e70b7912fc2da85a849da39c0d0d5394f51d4a9ed95c"];
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
        Command::new("cargo").args(["build", "--release", "--locked", "--bin", "pitchid"]).current_dir(root),
    )?;
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root.join("target"), PathBuf::from);
    let work = target.join("browser");
    fs::create_dir_all(&work).map_err(|error| error.to_string())?;
    let asker = Asker { browser, axe: axe(&target.join("tools"))? };
    asker.control(&work)?;
    let pages = pages(&target.join("release/pitchid"), &root.join("docs/effects/nominal.toml"), &work)?;
    let wrong: Vec<String> =
        pages.par_iter().map(|page| asker.wrong_with(page)).collect::<Outcome<Vec<_>>>()?.concat();
    if wrong.is_empty() { Ok(()) } else { Err(wrong.join("\n")) }
}

/// The script of axe-core, fetched once.
fn axe(tools: &Path) -> Outcome<String> {
    let [package, sum] = AXE;
    let place = tools.join("axe.min.js");
    if !place.exists() {
        fs::create_dir_all(tools).map_err(|error| error.to_string())?;
        let archive = output(Command::new("npm").args(["pack", "--silent", package]).current_dir(tools))?;
        let unpack = ["xzf", archive.trim(), "--strip-components=1", "package/axe.min.js"];
        output(Command::new("tar").args(unpack).current_dir(tools))?;
    }
    let found = output(Command::new("sha256sum").arg(&place))?;
    if !found.starts_with(sum) {
        return Err(format!("{}: not the {package} that is known; remove it", place.display()));
    }
    fs::read_to_string(&place).map_err(|error| format!("{}: {error}", place.display()))
}

/// Puts pages into the browser.
struct Asker {
    browser: &'static str,
    axe: String,
}

impl Asker {
    /// A page with everything wrong must be told so.
    fn control(&self, work: &Path) -> Outcome {
        let page = work.join("control.html");
        fs::write(&page, include_str!("browser_control.html")).map_err(|error| error.to_string())?;
        let said = self.asked(&page, 360, false)?;
        let told = [
            "fetches https://example.org",
            "8 px: small",
            "contrast",
            "px wide in 360",
            "has no name",
            "loud",
            "stand on one another",
            "leaves the order",
            "does not show that it is chosen",
            "axe image-alt",
        ];
        if let Some(missed) = told.into_iter().find(|what| !said.contains(what)) {
            return Err(format!("a page with everything wrong is not told \"{missed}\":\n{said}"));
        }
        let (_, cut) = self.printed(&page)?;
        match ["a figure is cut", "a heading stands alone"]
            .into_iter()
            .find(|what| !cut.iter().any(|c| c.contains(what)))
        {
            Some(missed) => Err(format!("a page with everything wrong is not told \"{missed}\": {cut:?}")),
            None => Ok(()),
        }
    }

    /// All that is wrong with a page, in every view and on paper.
    fn wrong_with(&self, page: &Path) -> Outcome<Vec<String>> {
        let name = page.file_stem().unwrap_or_default().to_string_lossy();
        let mut wrong = Vec::new();
        for (view, width, dark) in VIEWS {
            let said = self.asked(page, width, dark)?;
            println!("{name}, {view}: {}", said.lines().next().unwrap_or_default());
            wrong.extend(said.lines().skip(1).map(|line| format!("{name}, {view}: {line}")));
        }
        let (sheets, cut) = self.printed(page)?;
        println!("{name}, printed: {sheets} sheets");
        wrong.extend(cut.iter().map(|what| format!("{name}, printed: {what}")));
        Ok(wrong)
    }

    /// What a page says to the questions of `browser.js`: how much was asked, then what is wrong.
    fn asked(&self, page: &Path, width: u32, dark: bool) -> Outcome<String> {
        let text = fs::read_to_string(page).map_err(|error| format!("{}: {error}", page.display()))?;
        let questions = format!(
            "<head>{POLICY}<script>{}</script><script>{}</script>",
            self.axe,
            include_str!("browser.js")
        );
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
        let mut command = self.started();
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

    /// The sheets of a printed page, and what is torn apart on them: figures and cards that are cut, headings without what they head.
    /// The places of the page's parts are told by words that the printed copy has in them, found again in the text of each sheet.
    fn printed(&self, page: &Path) -> Outcome<(usize, Vec<String>)> {
        let text = fs::read_to_string(page).map_err(|error| format!("{}: {error}", page.display()))?;
        let (copy, paper) = (page.with_extension("printed.html"), page.with_extension("pdf"));
        let marked = text.replacen(
            "</body>",
            concat!("<script>", include_str!("browser_paper.js"), "</script></body>"),
            1,
        );
        fs::write(&copy, marked).map_err(|error| error.to_string())?;
        output(
            self.started()
                .arg("--no-pdf-header-footer")
                .arg(format!("--print-to-pdf={}", paper.display()))
                .arg(&copy),
        )?;
        let sheets = output(Command::new("pdftotext").arg(&paper).arg("-"))?;
        let sheets: Vec<&str> = sheets.trim_end_matches('\u{c}').split('\u{c}').collect();
        let sheet_of =
            |mark: &str| sheets.iter().position(|sheet| sheet.split_whitespace().any(|word| word == mark));
        let mut torn = Vec::new();
        for (sign, what) in
            [("figure", "a figure is cut"), ("card", "a card is cut"), ("heading", "a heading stands alone")]
        {
            for k in 0.. {
                let ends = [format!("{sign}{k}begins"), format!("{sign}{k}ends")].map(|mark| sheet_of(&mark));
                match ends {
                    [None, None] => break,
                    [Some(from), Some(to)] if from == to => {}
                    _ => torn.push(format!("{what}: the {sign} {}", k + 1)),
                }
            }
        }
        Ok((sheets.len(), torn))
    }

    fn started(&self) -> Command {
        let mut command = Command::new(self.browser);
        command.args([
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--hide-scrollbars",
            "--virtual-time-budget=20000",
        ]);
        command
    }
}

/// Tests that are flown for a page, by its name, and what is concealed in them.
const FLOWN: [(&str, &[&str]); 8] = [
    ("friction", &["--effect", "coulomb_friction"]),
    ("end-stop", &["--effect", "end_stop"]),
    ("lag", &["--effect", "servo_lag"]),
    ("window", &["--effect", "moment_step"]),
    ("ambiguous", &["--effect", "cubic_stiffness"]),
    ("unlisted", &["--effect", "angle_damping"]),
    ("none", &[]),
    ("still", &["--amplitude", "0"]),
];

/// Pages of every kind, made by the program.
fn pages(pitchid: &Path, model: &Path, work: &Path) -> Outcome<Vec<PathBuf>> {
    let run = |arguments: &[&str]| output(Command::new(pitchid).args(arguments).current_dir(work));
    let model = model.to_string_lossy();
    let mut pages = Vec::new();
    for (name, what) in FLOWN {
        let [log, page] = [format!("{name}.csv"), format!("{name}.html")];
        run(&[&["simulate", "--out", &log], what].concat())?;
        run(&["diagnose", &log, "--model", &model, "--report", &page])?;
        pages.push(page);
    }
    let log = "friction.csv";
    run(&["demo", "--out", "demo"])?;
    run(&["show", log, "--report", "show.html"])?;
    run(&["identify", log, "--report", "identified.html"])?;
    run(&["diagnose", log, "--time", "0..3", "--report", "refused.html"])?;
    run(&["diagnose", log, "--model", &model, "--column", "q_rad_s=-q_rad_s", "--report", "check.html"])?;
    run(&["diagnose", "still.csv", "--model", &model, "--time", "10..30", "--report", "not-excited.html"])?;
    run(&["diagnose", log, "--report", "without-model.html"])?;
    run(&["plan", "--model", &model, "--flights", "10", "--out", "bench"])?;
    pages.extend(
        [
            "demo/report.html",
            "show.html",
            "identified.html",
            "refused.html",
            "check.html",
            "not-excited.html",
            "without-model.html",
            "bench/page.html",
        ]
        .map(String::from),
    );
    Ok(pages.iter().map(|name| work.join(name)).collect())
}
