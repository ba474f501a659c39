//! What is counted along the path, counted from here once it has become long: a robot that stays on its dock between jobs is
//! not switched off for months, and a long sum swallows small terms.

use crate::slam::Slam;

/// Path after which it is counted anew, metres. Up to there a 32-bit float keeps steps of a twentieth of a millimetre.
pub(crate) const COUNTED_M: f32 = 1024.0;

impl<const S: usize, const W: usize, const B: usize, const ROWS: usize> Slam<S, W, B, ROWS> {
    /// Counts path, noise and calibration of dead reckoning from here where the path has become long. Only differences of
    /// them count, and these stay.
    pub(crate) fn count_anew_if_due(&mut self) {
        if self.drive.dead_reckoning.path_m > COUNTED_M {
            self.count_anew();
        }
    }

    #[cold]
    #[inline(never)]
    pub(crate) fn count_anew(&mut self) {
        let so_far = self.drive.dead_reckoning.count_anew();
        let path_m = so_far.path_m;
        self.candidates.count_anew(&so_far);
        self.map.count_anew(path_m);
        self.monitor.count_anew(path_m);
        self.correlation.bends.count_anew(path_m);
        self.frozen.count_anew(path_m);
        for sensor in &mut self.sensors {
            sensor.front_end.count_anew(path_m);
        }
    }
}
