//! The report: one HTML file that needs nothing else, readable in light and dark, on a phone and on paper.

mod component;
pub mod content;
mod correlations;
mod dependence;
mod figures;
pub mod identified;
mod map;
mod over_time;
mod page;
pub mod recorded;
pub mod repeat;
mod spectrum;
mod step;
pub mod traces;

pub use figures::{headline_trace, is_changed};

use content::Content;
use figures::Figures;
use repeat::Repeat;
use sysid::diagnosis::Diagnosis;
use sysid::estimate::per_inertia;
use sysid::recording::Recording;

/// What a report is made of.
pub struct Report<'a> {
    /// The answer in words.
    pub content: &'a Content,
    /// The answer with what is shown beside it.
    pub found: &'a Diagnosis,
    /// What was asked.
    pub recordings: &'a [Recording],
    /// How to do it again.
    pub repeat: Repeat,
}

impl Report<'_> {
    /// The pictures as files of their own, for light and dark pages: name and SVG.
    pub fn pictures(&self) -> Vec<(String, String)> {
        Figures::new(self).all().map(|figure| self.drawn(figure)).collect()
    }

    /// The picture that says most, as a file: the section in which the models differ most, else what was recorded.
    pub fn picture(&self) -> Option<String> {
        let figures = Figures::new(self);
        let figure = figures.first.or_else(|| figures.recorded.into_iter().next())?;
        Some(self.drawn(figure).1)
    }

    fn drawn(&self, figure: figures::Figure) -> (String, String) {
        let svg = figure.chart.file(figure.width);
        (figure.name, if self.content.answer.per_unit_inertia { per_inertia(&svg) } else { svg })
    }

    /// The page.
    pub fn html(&self) -> String {
        let page = page::page(self, &Figures::new(self));
        if self.content.answer.per_unit_inertia { per_inertia(&page) } else { page }
    }
}

#[cfg(test)]
pub mod fixture;
#[cfg(test)]
mod tests;
