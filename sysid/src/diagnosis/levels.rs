//! The levels at which the diagnosis decides: each a probability, a share, or a length with its source. Settings of the
//! searches stand with the searches.

/// A rival at least this probable is told, and a name with such a rival is not the only one (contract of the answer).
pub const PLAUSIBLE: f64 = 0.05;
/// Level of the family of tests for what is left, after Holm's correction.
pub const ADEQUACY: f64 = 0.01;
/// Share of what the fullest model closes that named terms must close to be the answer; what is beside them is a remainder.
pub const MATERIAL: f64 = 0.8;
/// Standard errors over blocks by which a name must gain on held-out data to be one: one in a hundred by chance.
pub const HELD_OUT_ERRORS: f64 = 2.33;
/// The same beyond doubt, as a discovery is in physics.
pub const BEYOND_DOUBT: f64 = 5.0;
/// Share, of the evidence and of the motion, below which a further name is told as a remainder, however certain it is. (The least share of a true second effect
/// in the practice set is 0.05.)
pub const WORTH_A_NAME: f64 = 0.03;
/// Share below which a name that the data hardly tell from a larger one's class mends the form of that one.
pub const MENDS: f64 = 0.1;
/// Share of the motion that the baseline leaves, 1 s ahead and the noise included, below which a further name is significant where
/// the sensors are good, and not material: where it moves the prediction by less, it is told as a remainder. (Of the amplitude
/// it is three hundredths: what nobody sees in a picture.)
pub const LAST_THOUSANDTH: f64 = 1e-3;
/// Share of the error without it that a name may leave to be material all the same.
pub const HALVED: f64 = 0.5;
/// Factor by which ∂M/∂u, or the size of the first name, is another one: a name without which it is counts as material, however little of
/// the prediction it moves.
pub const ANOTHER_GAIN: f64 = 1.2;
/// Most terms that one diagnosis adds: the room for their states; the evidence ends the search before.
pub const MOST_TERMS: usize = 5;
/// Odds of a false alarm of one check of the data (one in 1,000 recordings).
pub const DATA_CHECK: f64 = 1e-3;
/// Shortest data on which physics is asked for, s: a few switches of the input, or half a swing.
pub const SHORTEST_S: f64 = 2.0;
/// Widest 95 % interval of ∂M/∂u, relative, half width, with which the input still counts as seen.
pub const WIDEST_GAIN_INTERVAL: f64 = 0.5;
/// Widest 95 % interval of what axes share, relative, half width: a size that is not known is no finding.
pub const WIDEST_SHARED_INTERVAL: f64 = 0.5;
/// Parts into which data without sections are cut for the rotation: as many as a whole test has sections.
pub const PARTS: usize = 4;
/// Horizons of the predictions that a model is judged by, s.
pub const HORIZONS_S: [f64; 3] = [0.1, 0.3, LONGEST_HORIZON_S];
/// The longest of them, s.
pub const LONGEST_HORIZON_S: f64 = 1.0;
/// VAF of predictions 1 s ahead, held out, per cent, below which nothing is named that is known by how the vehicle follows the
/// input, unless [`THE_INPUTS_OWN`] is reached: most of the motion is then noise, in a loop that was closed unsaid the noise that
/// went round it. An answer without a name says so below all of them.
pub const SEEN: f64 = 50.0;
/// Share of what the past of the motion does not tell of the next 0.1 s that a model surely predicts, held out, from which on the
/// input is seen in a loop. In gusts nothing predicts a second, be the model the vehicle itself.
pub const THE_INPUTS_OWN: f64 = 0.5;
/// VAF of predictions 1 s ahead, held out, per cent, from which on what the input does not cause is too little to be told as a gust,
/// and what tests find that has neither name nor form too little to be told as missing.
pub const CALM: f64 = 98.0;
/// VAF of predictions at the best horizon, per cent, below which nothing follows from the input: a model that predicts nothing has
/// nothing that could be missing from it.
pub const SEEN_AT_ALL: f64 = 2.0;
/// Horizons at which lags of actuator and sensor are compared where no angle is measured, s, longest first: several lags long, and
/// short enough for a loop to have little part in it.
pub const LAG_HORIZONS_S: [f64; 2] = [0.3, 0.1];
