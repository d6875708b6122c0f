//! References of piecewise constant acceleration: one track per joint.
//!
//! ```text
//!   q̇_d      ______              q_d(t) = q_k + q̇_k (t − t_k) + ½ q̈_k (t − t_k)²      t_k ≤ t < t_{k+1}
//!           /      \
//!     _____/        \_____
//! ```

use super::TorqueWave;

/// Target of a joint at one time.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Target {
    /// `q_d` [rad or m].
    pub position: f64,
    /// `q̇_d` [rad/s or m/s].
    pub velocity: f64,
    /// `q̈_d` [rad/s² or m/s²].
    pub acceleration: f64,
    /// `τ` [N·m or N] that is imposed; `None`: the joint is controlled.
    pub torque: Option<f64>,
}

impl Target {
    /// Position and velocity after a duration [s] of constant acceleration.
    fn after(&self, duration: f64) -> Self {
        Self {
            position: self.position + duration * (self.velocity + 0.5 * duration * self.acceleration),
            velocity: self.velocity + duration * self.acceleration,
            ..*self
        }
    }
}

/// The reference of one joint, built piece by piece; after its last piece the joint rests.
#[derive(Debug, Clone, PartialEq)]
pub struct Track {
    /// Start time [s] and motion of every piece; the last entry is the end of the track.
    pieces: Vec<(f64, Target)>,
    /// Torque that is imposed for a time.
    imposed: Option<TorqueWave>,
}

impl Track {
    /// A track that starts at rest at this position [rad or m].
    pub fn at(position: f64) -> Self {
        Self { pieces: vec![(0.0, Target { position, ..Target::default() })], imposed: None }
    }

    /// Appends a piece of constant acceleration [rad/s² or m/s²]. Pieces of zero duration [s] are ignored.
    pub fn accelerate(&mut self, acceleration: f64, duration: f64) {
        if duration <= 0.0 {
            return;
        }
        let end = self.pieces.len() - 1;
        let (time, last) = &mut self.pieces[end];
        last.acceleration = acceleration;
        let next = (*time + duration, Target { acceleration: 0.0, ..last.after(duration) });
        self.pieces.push(next);
    }

    /// Continues at its present velocity.
    pub fn coast(&mut self, duration: f64) {
        self.accelerate(0.0, duration);
    }

    /// Changes its velocity to another one [rad/s or m/s] with an acceleration [rad/s² or m/s², > 0].
    pub fn change_velocity(&mut self, velocity: f64, acceleration: f64) {
        let change = velocity - self.end().velocity;
        self.accelerate(acceleration.copysign(change), change.abs() / acceleration);
        let end = self.pieces.len() - 1;
        self.pieces[end].1.velocity = velocity;
    }

    /// From rest to a velocity [rad/s or m/s] with one acceleration, constant for a time [s], and to rest with a
    /// deceleration [rad/s² or m/s², both > 0].
    pub fn trapezoid(&mut self, velocity: f64, acceleration: f64, constant: f64, deceleration: f64) {
        let towards = velocity.signum();
        self.accelerate(towards * acceleration, velocity.abs() / acceleration);
        self.coast(constant);
        self.accelerate(-towards * deceleration, velocity.abs() / deceleration);
        self.rest();
    }

    /// Rests for the duration of a wave of torque that is imposed from now on; it replaces one that was imposed before.
    pub fn impose(&mut self, wave: TorqueWave) {
        let start = self.duration();
        self.coast(wave.duration());
        self.imposed = Some(TorqueWave { start, ..wave });
    }

    /// The fastest move to a position within a speed [rad/s or m/s] and an acceleration [rad/s² or m/s²], from rest to
    /// rest.
    pub fn move_to(&mut self, position: f64, speed: f64, acceleration: f64) {
        let way = position - self.end().position;
        let peak = speed.min((way.abs() * acceleration).sqrt());
        if peak > 0.0 {
            self.trapezoid(peak.copysign(way), acceleration, way.abs() / peak - peak / acceleration, acceleration);
        }
        let end = self.pieces.len() - 1;
        self.pieces[end].1.position = position;
    }

    /// Sets a velocity that is only rounding error to zero.
    fn rest(&mut self) {
        let end = self.pieces.len() - 1;
        self.pieces[end].1.velocity = 0.0;
    }

    /// [s] Duration until rest.
    pub fn duration(&self) -> f64 {
        self.pieces[self.pieces.len() - 1].0
    }

    /// Target at the end of the track.
    pub fn end(&self) -> Target {
        self.pieces[self.pieces.len() - 1].1
    }

    /// [rad or m] Total distance travelled, in both directions.
    pub fn way(&self) -> f64 {
        let ways = self.pieces.windows(2).map(|pair| (pair[1].1.position - pair[0].1.position).abs());
        ways.sum()
    }

    /// The target at a time [s].
    pub fn sample(&self, time: f64) -> Target {
        let next = self.pieces.partition_point(|(start, _)| *start <= time);
        let (start, target) = &self.pieces[next.saturating_sub(1)];
        Target { torque: self.imposed.and_then(|wave| wave.at(time)), ..target.after((time - start).max(0.0)) }
    }
}

/// The reference of a machine, one track per joint.
#[derive(Debug, Clone, PartialEq)]
pub struct Profile {
    tracks: Vec<Track>,
}

impl Profile {
    /// The tracks in the order of the machine's joints.
    pub fn new(tracks: Vec<Track>) -> Self {
        Self { tracks }
    }

    /// Everything at rest at these positions [rad or m].
    pub fn at_rest(positions: &[f64]) -> Self {
        Self { tracks: positions.iter().map(|&position| Track::at(position)).collect() }
    }

    /// The joints' tracks.
    pub fn tracks(&self) -> &[Track] {
        &self.tracks
    }

    /// The joints' tracks, for appending.
    pub fn tracks_mut(&mut self) -> &mut [Track] {
        &mut self.tracks
    }

    /// [s] until everything rests.
    pub fn duration(&self) -> f64 {
        self.tracks.iter().map(Track::duration).fold(0.0, f64::max)
    }

    /// [rad or m] Total distance travelled by all joints, in both directions.
    pub fn way(&self) -> f64 {
        self.tracks.iter().map(Track::way).sum()
    }

    /// [rad or m] Positions at the start.
    pub fn start(&self) -> Vec<f64> {
        self.tracks.iter().map(|track| track.sample(0.0).position).collect()
    }

    /// Writes the targets at a time [s].
    pub fn sample(&self, time: f64, targets: &mut [Target]) {
        for (target, track) in targets.iter_mut().zip(&self.tracks) {
            *target = track.sample(time);
        }
    }
}
