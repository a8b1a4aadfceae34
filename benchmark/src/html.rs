//! One HTML file that needs nothing else: the frame and the look of every page.

use maud::{DOCTYPE, Markup, PreEscaped, html};

/// What all pages look like.
const STYLE: &str = include_str!("page.css");

/// A page with a style of its own beside that of all.
pub struct Document<'a> {
    /// Its title.
    pub title: &'a str,
    /// Style sheet of its own.
    pub style: &'a str,
    /// What it shows.
    pub body: Markup,
    /// JSON for programs, by the id of its element.
    pub json: Option<(&'a str, String)>,
}

impl Document<'_> {
    /// The file; `charts` where charts are on it.
    #[must_use]
    pub fn html(self, charts: bool) -> String {
        let (style, script) = if charts { (chart::STYLE, chart::SCRIPT) } else { ("", "") };
        html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    meta name="color-scheme" content="light dark";
                    title { (self.title) }
                    style { (PreEscaped(STYLE)) (PreEscaped(self.style)) (PreEscaped(style)) }
                }
                body {
                    main { (self.body) }
                    @if let Some((id, json)) = self.json {
                        // no text in it can end the element
                        script type="application/json" id=(id) {
                            (PreEscaped(json.replace('<', "\\u003c").replace('>', "\\u003e").replace('&', "\\u0026")))
                        }
                    }
                    @if charts { script { (PreEscaped(script)) } }
                }
            }
        }
        .into_string()
    }
}
