//! A proof that anyone can repeat: conceal and seal, diagnose, open the truths and count.

use crate::conceal::{Case, conceal};
use crate::judge::{Outcome, judge};
use crate::seal::{ANSWER, BESIDE, Folder, MODEL, RECORDING, SEAL};
use crate::truth::{Beside, Said, Sparse};
use crate::{Error, Table, black_box, files, page, sparse, tally};
use host_sim::Air;
use rayon::prelude::*;
use std::path::{Path, PathBuf};
use sysid::catalogue::model_file::parse_model;
use sysid::diagnosis::{Diagnosis, diagnose};
use sysid::recording::{ReadOptions, parse};

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
        self.each(done, |case| match self.is_sealed(case) {
            true => Ok(()),
            false => self.keep(case, &conceal(self.seed, self.air, case)?),
        })?;
        self.seals()
    }

    /// Whether a case is sealed.
    #[must_use]
    pub fn is_sealed(&self, case: u64) -> bool {
        self.folder.has(case, SEAL)
    }

    /// Writes a case and, last of all, its seal.
    ///
    /// # Errors
    /// A folder that cannot be written.
    pub fn keep(&self, case: u64, files: &Case) -> Result<(), Error> {
        let folder = &self.folder;
        folder.make(case)?;
        files::write(&folder.of(case, RECORDING), &files.recording)?;
        files::write(&folder.of(case, MODEL), &files.model)?;
        folder.seal(case, &files.truth)
    }

    /// Writes the hashes of all truths, and returns them.
    ///
    /// # Errors
    /// A case that is not sealed.
    pub fn seals(&self) -> Result<String, Error> {
        let lines = (0..self.cases).map(|case| self.folder.seal_line(case));
        let seals = lines.collect::<Result<String, Error>>()?;
        files::write(&self.folder.file("seals.txt"), &seals)?;
        Ok(seals)
    }

    /// Diagnoses every case from its recording and its model alone, and lets the two other methods try.
    ///
    /// # Errors
    /// A case that could not be read or written.
    pub fn diagnose(&self, done: &(dyn Fn() + Sync)) -> Result<(), Error> {
        self.each(done, |case| match self.is_answered(case) {
            true => Ok(()),
            false => {
                let [name, recording, model] = self.question(case)?;
                self.keep_answer(case, &answer(&name, &recording, &model)?)
            }
        })?;
        Ok(())
    }

    /// Whether a case was diagnosed.
    #[must_use]
    pub fn is_answered(&self, case: u64) -> bool {
        self.folder.has(case, BESIDE)
    }

    /// What a diagnosis sees of a case: what messages call its recording, the recording, the model.
    ///
    /// # Errors
    /// A case that cannot be read.
    pub fn question(&self, case: u64) -> Result<[String; 3], Error> {
        let place = self.folder.of(case, RECORDING);
        Ok([place.display().to_string(), files::read(&place)?, files::read(&self.folder.of(case, MODEL))?])
    }

    /// Writes what [`answer`] answered.
    ///
    /// # Errors
    /// A folder that cannot be written.
    pub fn keep_answer(&self, case: u64, [answer, beside]: &[String; 2]) -> Result<(), Error> {
        files::write(&self.folder.of(case, ANSWER), answer)?;
        files::write(&self.folder.of(case, BESIDE), beside)
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

/// Diagnoses a case from its recording and its model, and lets the other methods try: the JSON of both. `name` is what
/// messages call the recording.
///
/// # Errors
/// A recording or a model that cannot be read.
pub fn answer(name: &str, recording: &str, model: &str) -> Result<[String; 2], Error> {
    let recording = [parse(name, recording.as_bytes(), &ReadOptions::default())?];
    let model = parse_model(MODEL, model, None)?;
    let found = diagnose(&recording, Some(&model), &|_| ());
    let json = match &found {
        Ok(found) => files::json(&found.answer)?,
        // a refusal is an answer too, and counts as missed
        Err(error) => files::json(&serde_json::json!({ "refused": error.to_string() }))?,
    };
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
    Ok([json, files::json(&beside)?])
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
