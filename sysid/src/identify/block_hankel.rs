//! Block Hankel matrices of several stretches of data, and their Gram matrices for many block sizes at once.
//!
//! ```text
//! column j of a stretch:  u[j..j+2i], y[j..j+2i],  j = 0..L−2i      (no column crosses a joint)
//! past = rows 0..i,  future = rows i..2i
//! Z_i = [U_future; W; Y_future],  W = U_past (PI-MOESP) or [U_past; Y_past] (PO-MOESP)
//! ```
//!
//! Each block of Z_i Z_iᵀ is G\[r,s\] = Σ_j a\[j+r\] b\[j+s\]: apart from the ends a correlation at lag s − r that does not
//! depend on i. The correlations over the whole stretch are summed once; for each i the first row and column lose the
//! products beyond their ends, and the others follow along the diagonals,
//! G\[r+1,s+1\] = G\[r,s\] − a\[r\] b\[s\] + a\[m+r\] b\[m+s\] with m columns. Cost: 5 i (PI) or 8 i (PO) multiplications per sample
//! for the largest i, then about 5 i² for each i and stretch.
//!
//! Where a stretch has an unknown offset, each row of its columns is taken about its own mean: that removes a constant
//! exactly, and leaves Y_f = O X + T U_f as it is.

use super::fir::{Piece, dot};
use crate::error::{Error, ErrorKind};
use nalgebra::DMatrix;

/// Rows at a time, so that what one pass over the lags reads stays in the cache.
const CHUNK: usize = 2048;

/// What is correlated with the future outputs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Instruments {
    /// Past inputs (PI-MOESP): consistent whatever the colour of the noise.
    PastInputs,
    /// Past inputs and outputs (PO-MOESP): more efficient where the noise is white or part of the model.
    PastInputsAndOutputs,
}

/// Samples without a joint, the input shifted by the delay.
#[derive(Clone, Debug, PartialEq)]
pub struct Stretch {
    /// u\[k−d\], its unit.
    pub u: Vec<f64>,
    /// y\[k\], rad/s.
    pub y: Vec<f64>,
}

/// Cuts `pieces` into stretches: delayed inputs reach back within the run but never before its start, and rows where
/// the supervisor acted are left out unless `use_supervised`. Each stretch is taken about its means if `offset`, which
/// keeps digits. Stretches of fewer than `shortest` samples are dropped.
///
/// # Errors
/// A value that is not finite.
pub fn stretches(
    pieces: &[Piece],
    delay: usize,
    use_supervised: bool,
    offset: bool,
    shortest: usize,
) -> Result<Vec<Stretch>, Error> {
    let mut found = Vec::new();
    for piece in pieces {
        let length = piece.u.len().min(piece.y.len()).min(piece.supervised.len());
        let end = piece.rows.end.min(length);
        let mut start = piece.rows.start.max(delay);
        while start < end {
            let acted = |k: &usize| piece.supervised[*k] && !use_supervised;
            let stop = (start..end).find(acted).unwrap_or(end);
            if stop - start >= shortest.max(1) {
                let u = levelled(&piece.u[start - delay..stop - delay], offset);
                found.push(Stretch { u, y: levelled(&piece.y[start..stop], offset) });
            }
            start = stop + 1;
        }
    }
    if found.iter().all(|stretch| stretch.u.iter().chain(&stretch.y).all(|x| x.is_finite())) {
        return Ok(found);
    }
    let advice = "remove the rows with values that are no finite numbers";
    Err(Error::new(ErrorKind::Value, "an input or pitch rate that is not finite", advice))
}

fn levelled(x: &[f64], offset: bool) -> Vec<f64> {
    let mean = if offset { x.iter().sum::<f64>() / x.len() as f64 } else { 0.0 };
    x.iter().map(|x| x - mean).collect()
}

/// Number of columns of Z_i.
pub fn columns(stretches: &[Stretch], i: usize) -> usize {
    stretches.iter().map(|stretch| (stretch.u.len() + 1).saturating_sub(2 * i)).sum()
}

/// Z_iᵀ itself, one row per column of Z_i; with `offset` each row of Z_i about its mean in each stretch.
pub fn transposed(stretches: &[Stretch], i: usize, instruments: Instruments, offset: bool) -> DMatrix<f64> {
    let width = if instruments == Instruments::PastInputs { 3 * i } else { 4 * i };
    let mut z = DMatrix::zeros(columns(stretches, i), width);
    let mut row = 0;
    for stretch in stretches {
        let count = (stretch.u.len() + 1).saturating_sub(2 * i);
        for (block, (signal, from)) in blocks(stretch, i, instruments).into_iter().enumerate() {
            for r in 0..i {
                let mut target = z.column_mut(block * i + r);
                target.as_mut_slice()[row..row + count]
                    .copy_from_slice(&levelled(&signal[from + r..from + r + count], offset));
            }
        }
        row += count;
    }
    z
}

/// The signals and first rows of the blocks of Z_i, from top to bottom.
fn blocks(stretch: &Stretch, i: usize, instruments: Instruments) -> Vec<(&[f64], usize)> {
    let (u, y) = (stretch.u.as_slice(), stretch.y.as_slice());
    match instruments {
        Instruments::PastInputs => vec![(u, i), (u, 0), (y, i)],
        Instruments::PastInputsAndOutputs => vec![(u, i), (u, 0), (y, 0), (y, i)],
    }
}

/// Sums of products at each lag over whole stretches: what the Gram matrices of all block sizes share.
pub struct Correlations<'a> {
    stretches: &'a [Stretch],
    sums: Vec<Sums>,
    instruments: Instruments,
    offset: bool,
}

/// Σ_k a\[k\] b\[k+lag\] over one stretch.
struct Sums {
    input: Vec<f64>,
    input_output: Vec<f64>,
    output_input: Vec<f64>,
    output: Vec<f64>,
}

impl<'a> Correlations<'a> {
    /// For block sizes up to `largest`; with `offset` as in [`transposed`].
    pub fn new(stretches: &'a [Stretch], largest: usize, instruments: Instruments, offset: bool) -> Self {
        let past_outputs = instruments == Instruments::PastInputsAndOutputs;
        let sums = |stretch: &Stretch| {
            let (u, y) = (stretch.u.as_slice(), stretch.y.as_slice());
            Sums {
                input: correlate(u, u, 2 * largest),
                input_output: correlate(u, y, 2 * largest),
                output_input: correlate(y, u, if past_outputs { 2 * largest } else { largest }),
                output: if past_outputs { correlate(y, y, 2 * largest) } else { Vec::new() },
            }
        };
        Self { stretches, sums: stretches.iter().map(sums).collect(), instruments, offset }
    }

    /// W Wᵀ with W = \[U_future; instruments\] (its lower half), and W Y_futureᵀ.
    pub fn gram(&self, i: usize) -> (DMatrix<f64>, DMatrix<f64>) {
        let width = if self.instruments == Instruments::PastInputs { 2 * i } else { 3 * i };
        let (mut own, mut cross) = (DMatrix::zeros(width, width), DMatrix::zeros(width, i));
        for (stretch, sums) in self.stretches.iter().zip(&self.sums) {
            if stretch.u.len() < 2 * i {
                continue;
            }
            let (u, y) = (stretch.u.as_slice(), stretch.y.as_slice());
            let uu = Products { a: u, b: u, forward: &sums.input, backward: &sums.input, i };
            let uy = Products { a: u, b: y, forward: &sums.input_output, backward: &sums.output_input, i };
            uu.add(&mut own, (0, 0), (i, i), (i, i));
            uu.add(&mut own, (i, 0), (0, i), (i, i));
            uu.add(&mut own, (i, i), (0, 0), (i, i));
            uy.add(&mut cross, (0, 0), (i, i), (i, i));
            uy.add(&mut cross, (i, 0), (0, i), (i, i));
            if self.instruments == Instruments::PastInputsAndOutputs {
                let yu =
                    Products { a: y, b: u, forward: &sums.output_input, backward: &sums.input_output, i };
                let yy = Products { a: y, b: y, forward: &sums.output, backward: &sums.output, i };
                yu.add(&mut own, (2 * i, 0), (0, i), (i, i));
                yu.add(&mut own, (2 * i, i), (0, 0), (i, i));
                yy.add(&mut own, (2 * i, 2 * i), (0, 0), (i, i));
                yy.add(&mut cross, (2 * i, 0), (0, i), (i, i));
            }
            if self.offset {
                self.take_means_off(stretch, i, &mut own, &mut cross);
            }
        }
        (own, cross)
    }

    /// G\[r,s\] ← G\[r,s\] − (Σ a)(Σ b) / m for the rows of one stretch.
    fn take_means_off(&self, stretch: &Stretch, i: usize, own: &mut DMatrix<f64>, cross: &mut DMatrix<f64>) {
        let count = stretch.u.len() + 1 - 2 * i;
        let sums: Vec<f64> = blocks(stretch, i, self.instruments)
            .into_iter()
            .flat_map(|(signal, from)| moving_sums(&signal[from..from + i - 1 + count], count))
            .collect();
        let (instruments, outputs) = sums.split_at(sums.len() - i);
        for (s, sum) in instruments.iter().enumerate() {
            let factor = sum / count as f64;
            for (g, other) in own.column_mut(s).as_mut_slice().iter_mut().zip(instruments) {
                *g -= other * factor;
            }
        }
        for (s, sum) in outputs.iter().enumerate() {
            let factor = sum / count as f64;
            for (g, other) in cross.column_mut(s).as_mut_slice().iter_mut().zip(instruments) {
                *g -= other * factor;
            }
        }
    }
}

/// The products of two signals of one stretch, for block size i.
struct Products<'a> {
    a: &'a [f64],
    b: &'a [f64],
    /// Sums of a\[k\] b\[k+lag\] and of a\[k+lag\] b\[k\].
    forward: &'a [f64],
    backward: &'a [f64],
    i: usize,
}

impl Products<'_> {
    /// Adds the block with first rows `from` of a and b to `target` at `at`.
    fn add(&self, target: &mut DMatrix<f64>, at: (usize, usize), from: (usize, usize), size: (usize, usize)) {
        let count = self.a.len() + 1 - 2 * self.i;
        let mut previous: Vec<f64> = Vec::new();
        for s in 0..size.1 {
            let b_row = from.1 + s;
            let mut column = Vec::with_capacity(size.0);
            column.push(self.entry(from.0, b_row));
            if s == 0 {
                column.extend((1..size.0).map(|r| self.entry(from.0 + r, b_row)));
            } else {
                let (left, entered) = (self.b[b_row - 1], self.b[b_row - 1 + count]);
                let leaves = &self.a[from.0..from.0 + size.0 - 1];
                let enters = &self.a[from.0 + count..from.0 + count + size.0 - 1];
                column.extend(
                    previous
                        .iter()
                        .zip(leaves)
                        .zip(enters)
                        .map(|((g, old), new)| g - old * left + new * entered),
                );
            }
            let place = &mut target.column_mut(at.1 + s);
            for (sum, g) in place.as_mut_slice()[at.0..].iter_mut().zip(&column) {
                *sum += g;
            }
            previous = column;
        }
    }

    /// One entry from the sum over the whole stretch, less the products before and after the columns.
    fn entry(&self, a_row: usize, b_row: usize) -> f64 {
        let count = self.a.len() + 1 - 2 * self.i;
        let (early, late, sums, first, lag) = if b_row >= a_row {
            (self.a, self.b, self.forward, a_row, b_row - a_row)
        } else {
            (self.b, self.a, self.backward, b_row, a_row - b_row)
        };
        sums[lag]
            - dot(&early[..first], &late[lag..lag + first])
            - dot(&early[first + count..early.len() - lag], &late[first + count + lag..])
    }
}

/// Sums of `count` neighbours of x.
fn moving_sums(x: &[f64], count: usize) -> Vec<f64> {
    let first = x[..count].iter().sum::<f64>();
    let changes = x[count..].iter().zip(x).map(|(new, old)| new - old);
    [first]
        .into_iter()
        .chain(changes.scan(first, |sum, change| {
            *sum += change;
            Some(*sum)
        }))
        .collect()
}

fn correlate(a: &[f64], b: &[f64], lags: usize) -> Vec<f64> {
    let mut sums = vec![0.0; lags];
    for start in (0..a.len()).step_by(CHUNK) {
        for (lag, sum) in sums.iter_mut().enumerate() {
            let end = (start + CHUNK).min(a.len().saturating_sub(lag)).max(start);
            if start + lag <= b.len() {
                *sum += dot(&a[start..end], &b[start + lag..end + lag]);
            }
        }
    }
    sums
}
