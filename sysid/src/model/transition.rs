//! A step of the linear model, as the inner loop of a simulation wants it.

use crate::model::plant::{DISTURBANCE, GUST, STATES, State, StateMatrix};

/// A state matrix by columns, the disturbance's block apart: it acts on the plant, the plant never on it.
pub struct Transition {
    on_plant: [[f64; DISTURBANCE]; STATES],
    on_disturbance: [[f64; 2]; 2],
    on_gust: f64,
}

impl Transition {
    /// Takes `matrix` apart.
    pub fn new(matrix: &StateMatrix) -> Self {
        Self {
            on_plant: core::array::from_fn(|j| core::array::from_fn(|i| matrix[(i, j)])),
            on_disturbance: core::array::from_fn(|j| {
                core::array::from_fn(|i| matrix[(DISTURBANCE + i, DISTURBANCE + j)])
            }),
            on_gust: matrix[(GUST, GUST)],
        }
    }

    /// The matrix times `x`.
    pub fn apply(&self, x: &State) -> State {
        let mut plant = [0.0; DISTURBANCE];
        for (column, &x) in self.on_plant.iter().zip(x.iter()) {
            for (sum, &entry) in plant.iter_mut().zip(column) {
                *sum += entry * x;
            }
        }
        let [a, b] = self.on_disturbance;
        let (first, second) = (x[DISTURBANCE], x[DISTURBANCE + 1]);
        let [q, q_imu, theta, theta_imu, gyro] = plant;
        let disturbance = [a[0] * first + b[0] * second, a[1] * first + b[1] * second];
        State::from([
            q,
            q_imu,
            theta,
            theta_imu,
            gyro,
            disturbance[0],
            disturbance[1],
            self.on_gust * x[GUST],
        ])
    }
}
