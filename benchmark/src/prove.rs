//! A proof that anyone can repeat: conceal and seal, diagnose, open the truths and count.

use crate::judge::{Outcome, judge};
use crate::seal::{ANSWER, BESIDE, Folder, MODEL, RECORDING, SEAL};
use crate::truth::{Beside, Said, Sparse};
use crate::{Error, Table, black_box, conceal, files, page, sparse, tally};
use host_sim::Air;
use rayon::prelude::*;
use std::path::{Path, PathBuf};
use sysid::catalogue::model_file::read_model;
use sysid::diagnosis::{Diagnosis, diagnose};
use sysid::recording::{ReadOptions, read};

/// A proof in its folder. Its three steps do several cases at a time, on the threads of the caller's rayon pool, leave out
/// what the folder holds already, and call `done` after each case; the first case that fails, by number, is the failure of
/// all.
pub struct Proof {
    folder: Folder,
    seed: u64,
    cases: u64,
    air: Air,
}

impl Proof {
    /// A proof of `cases` that `seed` draws, flown in `air`, in a new folder or, where `resume` says so, in one where it was begun.
    ///
    /// # Errors
    /// A folder that cannot be written, or holds another proof.
    pub fn open(folder: &Path, seed: u64, cases: u64, air: Air, resume: bool) -> Result<Self, Error> {
        Ok(Self { folder: Folder::open(folder, seed, air, resume)?, seed, cases, air })
    }

    /// Conceals and seals; the answer is the hash of every truth, a line each as `sha256sum` writes it.
    ///
    /// # Errors
    /// A case that could not be flown or written.
    pub fn seal(&self, done: &(dyn Fn() + Sync)) -> Result<String, Error> {
        let Self { folder, seed, cases, air } = self;
        self.each(done, |case| {
            if folder.has(case, SEAL) { Ok(()) } else { conceal::conceal(folder, *seed, *air, case) }
        })?;
        let seals: String = (0..*cases).map(|case| folder.seal_line(case)).collect::<Result<_, _>>()?;
        files::write(&folder.file("seals.txt"), &seals)?;
        Ok(seals)
    }

    /// Diagnoses every case from its recording and its model alone, and lets the two other methods try.
    ///
    /// # Errors
    /// A case that could not be read or written.
    pub fn diagnose(&self, done: &(dyn Fn() + Sync)) -> Result<(), Error> {
        let folder = &self.folder;
        self.each(done, |case| if folder.has(case, BESIDE) { Ok(()) } else { answer(folder, case) })?;
        Ok(())
    }

    /// Opens the truths, counts, and writes the results and the report.
    ///
    /// # Errors
    /// A truth that is not the sealed one, or a file that could not be read or written.
    pub fn count(&self, done: &(dyn Fn() + Sync)) -> Result<Vec<Table>, Error> {
        let outcomes = self.each(done, |case| open(&self.folder, case))?;
        let tables = tally::tables(&outcomes);
        files::write(&self.folder.file("results.json"), &files::json(&outcomes)?)?;
        let markdown: String = tables.iter().map(Table::markdown).collect();
        let (command, lead) = (page::command(outcomes.len(), self.seed, self.air), page::lead(&outcomes));
        files::write(&self.folder.file("table.md"), &format!("{lead} `{command}`\n\n{markdown}"))?;
        files::write(&self.report(), &page::html(&outcomes, &tables, self.seed, self.air))?;
        Ok(tables)
    }

    /// Where the report lies.
    #[must_use]
    pub fn report(&self) -> PathBuf {
        self.folder.file("report.html")
    }

    fn each<T: Send>(
        &self,
        done: &(dyn Fn() + Sync),
        one: impl Fn(u64) -> Result<T, Error> + Sync,
    ) -> Result<Vec<T>, Error> {
        let all: Vec<Result<T, Error>> =
            (0..self.cases).into_par_iter().map(|case| one(case).inspect(|_| done())).collect();
        all.into_iter().collect()
    }
}

/// Diagnoses one case, from its recording and its model, and lets the other methods try.
fn answer(folder: &Folder, case: u64) -> Result<(), Error> {
    let recording = [read(&folder.of(case, RECORDING), &ReadOptions::default())?];
    let model = read_model(&folder.of(case, MODEL), None)?;
    let found = diagnose(&recording, Some(&model), &|_| ());
    let json = match &found {
        Ok(found) => files::json(&found.answer)?,
        // a refusal is an answer too, and counts as missed
        Err(error) => files::json(&serde_json::json!({ "refused": error.to_string() }))?,
    };
    files::write(&folder.of(case, ANSWER), &json)?;
    let nothing = Sparse { terms: Vec::new(), ids: Vec::new(), vaf_percent: Default::default() };
    let parameters = found.as_ref().map_or(0, added_parameters).max(2);
    let beside = Beside {
        sparse: sparse::regress(&recording[0], &model).unwrap_or(nothing),
        black_box_vaf_percent: found
            .as_ref()
            .map(|found| black_box::correct(&recording[0], &found.traces, parameters))
            .unwrap_or_default(),
        black_box_parameters: parameters,
    };
    files::write(&folder.of(case, BESIDE), &files::json(&beside)?)
}

/// Number of parameters that the diagnosis added.
fn added_parameters(found: &Diagnosis) -> usize {
    found.answer.effects.iter().map(|effect| effect.parameters.len()).sum()
}

/// Opens the truth of a case and holds the answer against it.
fn open(folder: &Folder, case: u64) -> Result<Outcome, Error> {
    let truth = folder.open_truth(case)?;
    let answer: serde_json::Value = files::read_json(&folder.of(case, ANSWER))?;
    let beside: Beside = files::read_json(&folder.of(case, BESIDE))?;
    let said: Option<Said> = if answer.get("refused").is_some() {
        None
    } else {
        Some(files::read_json(&folder.of(case, ANSWER))?)
    };
    Ok(judge(&truth, said.as_ref(), &beside))
}
