//! A step of the linear model, as the inner loop of a simulation wants it.

use crate::model::plant::{DISTURBANCE, STATES, State, StateMatrix};

/// A state matrix by columns, the disturbance's block apart: it acts on the plant, the plant never on it.
pub struct Transition {
    on_plant: [[f64; DISTURBANCE]; STATES],
    /// By rows.
    on_disturbance: [[f64; 3]; 3],
}

impl Transition {
    /// Takes `matrix` apart.
    pub fn new(matrix: &StateMatrix) -> Self {
        Self {
            on_plant: core::array::from_fn(|j| core::array::from_fn(|i| matrix[(i, j)])),
            on_disturbance: core::array::from_fn(|i| {
                core::array::from_fn(|j| matrix[(DISTURBANCE + i, DISTURBANCE + j)])
            }),
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
        let noise = [x[DISTURBANCE], x[DISTURBANCE + 1], x[DISTURBANCE + 2]];
        let [first, second, third] =
            self.on_disturbance.map(|row| row[0] * noise[0] + row[1] * noise[1] + row[2] * noise[2]);
        let [q, q_imu, theta, theta_imu, gyro] = plant;
        State::from([q, q_imu, theta, theta_imu, gyro, first, second, third])
    }
}
