//! A tiny world: walls as segments, perfect pose, ideal beams.
use super::*;
use crate::condition::Condition;
use crate::contact::Contacts;
use crate::wild::Wild;
extern crate std;
use std::{eprintln, vec, vec::Vec};

type Seg = ([f32; 2], [f32; 2]);
fn rect(x0: f32, y0: f32, x1: f32, y1: f32) -> Vec<Seg> {
    vec![([x0, y0], [x1, y0]), ([x1, y0], [x1, y1]), ([x1, y1], [x0, y1]), ([x0, y1], [x0, y0])]
}
fn ray(o: [f32; 2], d: [f32; 2], s: &Seg) -> Option<f32> {
    let (a, b) = s;
    let e = [b[0] - a[0], b[1] - a[1]];
    let den = d[0] * e[1] - d[1] * e[0];
    if den.abs() < 1e-9 { return None; }
    let w = [a[0] - o[0], a[1] - o[1]];
    let t = (w[0] * e[1] - w[1] * e[0]) / den;
    let u = (w[0] * d[1] - w[1] * d[0]) / den;
    (t > 0.0 && (0.0..=1.0).contains(&u)).then_some(t)
}
fn near_seg(p: [f32; 2], s: &Seg) -> ([f32; 2], f32) {
    let (a, b) = s;
    let e = [b[0] - a[0], b[1] - a[1]];
    let l2 = (e[0] * e[0] + e[1] * e[1]).max(1e-12);
    let t = (((p[0] - a[0]) * e[0] + (p[1] - a[1]) * e[1]) / l2).clamp(0.0, 1.0);
    let q = [a[0] + t * e[0], a[1] + t * e[1]];
    (q, slam_core::pose::length(p[0] - q[0], p[1] - q[1]))
}
struct World { segs: Vec<Seg>, at: Pose, job: FloorJob<8>, bounds: Bounds, s: u64, wild: Wild, out_steps: u32, bumps: u32, battery: Option<f32>, dock: Option<Pose>, seen: Vec<(u64, FloorState)>, t0: u64, far: [f32; 4] }
impl World {
    fn new(segs: Vec<Seg>, at: Pose) -> Self {
        Self { segs, at, job: FloorJob::new(FloorConfig::default(), &crate::rig::default_rig()), bounds: Bounds::NONE, s: 0, wild: Wild::new(), out_steps: 0, bumps: 0, battery: None, dock: None, seen: Vec::new(), t0: 0, far: [0.0; 4] }
    }
    fn step(&mut self) {
        self.s += 1;
        let mut ranges_m = [None; 8];
        for (beam, range) in self.job.beams.iter().zip(&mut ranges_m) {
            let o = self.at.transform(beam.mount_m);
            let to = self.at.transform(beam.point_m(1.0));
            let d = [to[0] - o[0], to[1] - o[1]];
            let t = self.segs.iter().filter_map(|s| ray(o, d, s)).fold(f32::INFINITY, f32::min);
            let t = t * (1.0 + 0.004 * self.wild.share());
            if t >= 0.155 && t <= 1.5 { *range = Some(t); }
        }
        let p = [self.at.x_m, self.at.y_m];
        let mut contacts = Contacts::default();
        for s in &self.segs {
            let (q, d) = near_seg(p, s);
            if d < 0.1705 {
                let [x, y] = self.at.inverse().transform(q);
                let b = libm::atan2f(y, x);
                if b.abs() < 1.4 { if b > -0.2 { contacts.bump_left = true; } if b < 0.2 { contacts.bump_right = true; } }
            }
        }
        if contacts.any() { self.bumps += 1; }
        let is_charging = self.dock.is_some_and(|dock| { let r = dock.inverse().compose(&self.at); r.x_m > -0.01 && r.y_m.abs() < 0.03 && r.theta_rad.abs() < 0.17 });
        let condition = Condition { battery_v: self.battery, is_charging, ..Condition::default() };
        let senses = Senses { time_us: self.t0 + 40_000 * self.s, pose: self.at, ranges_m, contacts, condition };
        let bounds = self.bounds.clone();
        let speeds = contacts.guard(self.job.step_within(&senses, &bounds));
        if self.s == 50 { self.job.align(0.0); }
        let (f, tn) = (0.02 * (speeds.left_mps + speeds.right_mps), 0.04 * (speeds.right_mps - speeds.left_mps) / 0.235);
        let next = self.at.compose(&Pose::new(f, 0.0, tn));
        let mut q = [next.x_m, next.y_m];
        for _ in 0..3 { for s in &self.segs { let (n, d) = near_seg(q, s); if d < 0.17 { let k = 0.17 / d.max(1e-4); q = [n[0] + (q[0] - n[0]) * k, n[1] + (q[1] - n[1]) * k]; } } }
        self.at = Pose { x_m: q[0], y_m: q[1], theta_rad: next.theta_rad };
        if self.bounds.is_out(q) { self.out_steps += 1; }
        self.far = [self.far[0].min(q[0]), self.far[1].max(q[0]), self.far[2].min(q[1]), self.far[3].max(q[1])];
        if self.seen.last().map(|x| x.1) != Some(self.job.state()) { self.seen.push((self.s / 25, self.job.state())); }
    }
    fn run(&mut self, most_s: u64, name: &str) {
        let mut marks = Vec::new();
        for s in 1..=25 * most_s {
            self.step();
            if s % (25 * 600) == 0 { marks.push((s / 25 / 60, (self.job.progress().swept_m2 * 10.0) as i32, self.job.path_m as i32)); }
            if self.job.is_over() { break; }
        }
        let p = self.job.progress();
        let d = self.job.home.map(|h| slam_core::pose::length(h.x_m - self.at.x_m, h.y_m - self.at.y_m));
        eprintln!("{name}: {:?} after {} min, swept {:.1} left {:.1} m2, path {:.0} m, home {d:?}, out {} bumps {} far {:?}\n   planning {} s edge {} lane {} back {} wait {} (min, dm2, m) {marks:?}", p.state, self.s / 1500, p.swept_m2, p.left_m2, self.job.path_m, self.out_steps, self.bumps, self.far, p.seconds_in[3], p.seconds_in[0], p.seconds_in[1], p.seconds_in[4], p.seconds_in[20]);
    }
}

#[test]
fn a_halls() {
    for (w, h) in [(10.5, 10.0), (12.0, 8.0), (14.0, 14.0), (30.0, 1.4)] {
        World::new(rect(-1.0, -1.0, w - 1.0, h - 1.0), Pose::ORIGIN).run(3 * 3600, &std::format!("hall {w} x {h}"));
    }
}
/// A flat of 11.6 by 10 m with inner walls and doors of 0.9 m.
fn flat() -> Vec<Seg> {
    let mut s = rect(-1.0, -1.0, 10.6, 9.0);
    s.extend([([4.0, -1.0], [4.0, 2.0]), ([4.0, 2.9], [4.0, 6.0]), ([4.0, 6.9], [4.0, 9.0])]);
    s.extend([([4.0, 4.5], [6.0, 4.5]), ([6.9, 4.5], [10.6, 4.5]), ([-1.0, 4.0], [1.0, 4.0]), ([1.9, 4.0], [4.0, 4.0])]);
    s
}
#[test]
fn b_flat() { World::new(flat(), Pose::ORIGIN).run(3 * 3600, "flat 116 m2"); }
#[test]
fn d_corridor() {
    World::new(rect(-1.0, -1.0, 23.0, 2.0), Pose::ORIGIN).run(3 * 3600, "corridor 24 x 3");
    World::new(rect(-1.0, -1.0, 15.0, 4.0), Pose::ORIGIN).run(3 * 3600, "hall 16 x 5");
}
fn keep(corners: &[[f32; 2]]) -> Bounds { let mut b = Bounds::NONE; b.add(AreaKind::KeepOut, corners).unwrap(); b }
#[test]
fn c_keep_outs() {
    let room = || rect(-1.0, -1.0, 4.0, 3.0);
    for (name, corners) in [
        ("square in the middle", vec![[1.0, 0.5], [2.0, 0.5], [2.0, 1.5], [1.0, 1.5]]),
        ("clockwise", vec![[1.0, 0.5], [1.0, 1.5], [2.0, 1.5], [2.0, 0.5]]),
        ("bow tie", vec![[1.0, 0.3], [2.2, 1.7], [2.2, 0.3], [1.0, 1.7]]),
        ("about the start", vec![[-0.6, -0.6], [0.6, -0.6], [0.6, 0.6], [-0.6, 0.6]]),
        ("across the room", vec![[1.2, -2.0], [1.5, -2.0], [1.5, 4.0], [1.2, 4.0]]),
        ("thin sliver", vec![[1.2, 0.0], [1.25, 0.0], [1.25, 2.0], [1.2, 2.0]]),
        ("all but the start", vec![[-0.5, -0.5], [5.0, -0.5], [5.0, 5.0], [-0.5, 5.0]]),
        ("beside the start", vec![[0.25, -0.5], [1.0, -0.5], [1.0, 0.5], [0.25, 0.5]]),
    ] {
        let mut w = World::new(room(), Pose::ORIGIN);
        w.bounds = keep(&corners);
        w.run(3600, name);
    }
}
#[test]
fn e_late_start() {
    for t0 in [0, 60_000_000] {
        let mut w = World::new(flat_small(), Pose::new(0.0, 0.0, 0.3));
        w.t0 = t0;
        w.run(3600, &std::format!("small flat, first step at {} s", t0 / 1_000_000));
    }
}
fn flat_small() -> Vec<Seg> {
    let mut s = rect(-1.0, -1.0, 6.0, 5.0);
    s.extend([([2.5, -1.0], [2.5, 1.0]), ([2.5, 1.9], [2.5, 5.0]), ([2.5, 2.5], [4.0, 2.5]), ([4.9, 2.5], [6.0, 2.5])]);
    s
}
#[test]
fn f_lengths() {
    for (l, h) in [(11.0, 4.0), (12.5, 4.0), (13.5, 4.0), (16.0, 4.0), (20.0, 4.0)] {
        World::new(rect(-1.0, -1.0, l - 1.0, h - 1.0), Pose::ORIGIN).run(3 * 3600, &std::format!("{l} x {h}, {:.0} m2", l * h));
    }
}
#[test]
fn g_long_flat() {
    // Rooms of 4 x 4 m in a row with doors of 0.9 m: 16 m.
    for n in [3, 4, 5] {
        let mut s = rect(-1.0, -1.0, 4.0 * n as f32 - 1.0, 3.0);
        for k in 1..n { let x = 4.0 * k as f32 - 1.0; s.extend([([x, -1.0], [x, 0.5]), ([x, 1.4], [x, 3.0])]); }
        World::new(s, Pose::ORIGIN).run(3 * 3600, &std::format!("{n} rooms of 4 x 4 in a row"));
    }
}
fn clean(corners: &[&[[f32; 2]]]) -> Bounds { let mut b = Bounds::NONE; for c in corners { b.add(AreaKind::Clean, c).unwrap(); } b }
fn sq(x: f32, y: f32, w: f32, h: f32) -> [[f32; 2]; 4] { [[x, y], [x + w, y], [x + w, y + h], [x, y + h]] }
#[test]
fn h_clean_areas() {
    for (name, segs, b) in [
        ("area in the same room", rect(-1.0, -1.0, 6.0, 3.0), clean(&[&sq(3.0, 0.0, 2.0, 2.0)])),
        ("area 9 m away, one room", rect(-1.0, -1.0, 12.0, 3.0), clean(&[&sq(9.0, 0.0, 2.0, 2.0)])),
        ("area 15 m away", rect(-1.0, -1.0, 19.0, 3.0), clean(&[&sq(15.0, 0.0, 2.0, 2.0)])),
        ("two areas 15 m apart", rect(-1.0, -1.0, 19.0, 3.0), clean(&[&sq(15.0, 0.0, 2.0, 2.0), &sq(0.0, 1.0, 1.5, 1.5)])),
        ("area within walls", { let mut s = rect(-1.0, -1.0, 6.0, 3.0); s.extend(rect(3.0, 0.0, 5.0, 2.0)); s }, clean(&[&sq(3.5, 0.5, 1.0, 1.0)])),
        ("area outside", rect(-1.0, -1.0, 6.0, 3.0), clean(&[&sq(20.0, 0.5, 1.0, 1.0)])),
        ("area outside at the back", rect(-1.0, -1.0, 6.0, 3.0), clean(&[&sq(-20.0, -9.0, 1.0, 1.0)])),
        ("tiny area", rect(-1.0, -1.0, 6.0, 3.0), clean(&[&sq(4.0, 1.5, 0.05, 0.05)])),
        ("beside a keep-out that is within it", rect(-1.0, -1.0, 6.0, 3.0), { let mut b = clean(&[&sq(2.0, -0.5, 3.0, 3.0)]); b.add(AreaKind::KeepOut, &sq(3.0, 0.5, 1.0, 1.0)).unwrap(); b }),
        ("keep-out shuts the area off", rect(-1.0, -1.0, 6.0, 3.0), { let mut b = clean(&[&sq(4.0, -0.5, 1.5, 3.0)]); b.add(AreaKind::KeepOut, &sq(2.0, -2.0, 0.5, 6.0)).unwrap(); b }),
    ] {
        let mut w = World::new(segs, Pose::ORIGIN);
        w.bounds = b;
        w.run(2 * 3600, name);
        eprintln!("   missed {:b}", w.job.progress().missed);
    }
}
#[test]
fn i_keep_out_moves_by_itself() {
    // The map moves the area in the first twenty seconds, by half a metre.
    for moves in [false, true] {
        let mut w = World::new(rect(-1.0, -1.0, 5.0, 3.0), Pose::ORIGIN);
        for k in 0..25 * 60 { w.bounds = keep(&sq(if moves { 2.0 - 0.5 * (1.0 - f32::min(1.0, k as f32 / 1500.0)) } else { 2.0 }, -0.2, 1.0, 1.4)); w.step(); }
        w.run(3600, "keep-out that moved");
        let middle = |x: f32, y: f32| w.job.sheet.picture.cell_at(x, y);
        let left: u32 = (0..9).map(|k| w.job.sheet.swept.left_in(middle(1.65, -0.1 + 0.156 * k as f32))).sum();
        eprintln!("   quarters not swept of 36 in the column at 1.65 m: {left}");
    }
}
#[test]
fn j_battery() {
    for (name, pause) in [("dock", 0), ("dock, pause on the way home", 1)] {
        let mut w = World::new(rect(-3.0, -3.0, 0.17, 3.0), Pose::ORIGIN);
        w.dock = Some(Pose::ORIGIN);
        w.battery = Some(12.4);
        for _ in 0..25 * 200 { w.step(); }
        w.battery = Some(10.4);
        if pause == 1 {
            while w.job.state() != FloorState::Return { w.step(); }
            w.job.pause();
            for _ in 0..250 { w.step(); }
            w.job.resume();
        }
        let from = w.job.path_m; let s0 = w.s;
        while w.job.state() != FloorState::Charging && w.s < s0 + 25 * 1800 && !w.job.is_over() { w.step(); }
        eprintln!("{name}: {:?} after {} s and {:.1} m", w.job.state(), (w.s - s0) / 25, w.job.path_m - from);
        w.battery = Some(12.6);
        w.run(3600, name);
    }
}
#[test]
fn k_clutter() {
    let mut wild = Wild::new();
    let mut u = |lo: f32, hi: f32| lo + (hi - lo) * 0.5 * (wild.share() + 1.0);
    for seed in 0..90 {
        let (w, h) = (u(3.0, 7.0), u(3.0, 6.0));
        let mut s = rect(-1.0, -1.0, w - 1.0, h - 1.0);
        for _ in 0..(u(0.0, 8.0) as u32) {
            let (bx, by, bw, bh) = (u(-1.0, w - 1.2), u(-1.0, h - 1.2), u(0.03, 1.2), u(0.03, 0.8));
            if bx < 0.6 && bx + bw > -0.6 && by < 0.6 && by + bh > -0.6 { continue; }
            s.extend(rect(bx, by, bx + bw, by + bh));
        }
        for _ in 0..(u(0.0, 10.0) as u32) {
            let (bx, by) = (u(-1.0, w - 1.2), u(-1.0, h - 1.2));
            if bx.abs() < 0.5 && by.abs() < 0.5 { continue; }
            s.extend(rect(bx, by, bx + 0.03, by + 0.03));
        }
        let mut r = World::new(s, Pose::new(0.0, 0.0, u(-3.1, 3.1)));
        if seed < 89 { continue; }
        for q in &r.segs { eprintln!("{q:?}"); }
        for _ in 0..25 * 7200 { r.step(); if r.s % 1000 == 0 { eprintln!("{} {:?} {:?} {:?} retries {}", r.s / 25, r.at, r.job.state(), r.job.errand, r.job.retries); } if r.job.is_over() { break; } }
        let m = r.job.sheet.picture.cell_at(0.0, 0.0);
        let here = r.job.sheet.picture.cell_at(r.at.x_m, r.at.y_m);
        for row in (-8..20).rev() { let line: std::string::String = (-8..24).map(|c| { let cell = m.offset(c, row); if cell == here { 'R' } else if (c, row) == (0, 0) { 'H' } else if r.job.sheet.picture.is_obstacle(cell) { '#' } else if !r.job.sheet.picture.is_free(cell) { ' ' } else if r.job.sheet.swept.left_in(cell) > 0 { 'o' } else { '.' } }).collect(); eprintln!("{line}"); }
        let p = r.job.progress();
        let home = r.job.home.map_or(9.0, |h| slam_core::pose::length(h.x_m - r.at.x_m, h.y_m - r.at.y_m));
        if p.state != FloorState::Done || home > 0.05 || p.share() < 0.95 || r.s > 25 * 3000 || p.swept_m2 > w * h {
            eprintln!("K {seed}: {:?} {:.1}x{:.1} min {} swept {:.1} left {:.1} home {home:.2} bumps {} path {:.0} secs {:?}", p.state, w, h, r.s / 1500, p.swept_m2, p.left_m2, r.bumps, r.job.path_m, p.seconds_in);
        }
    }
}

/// Cells of 10 cm that the brush came to, of those where the robot's centre can be.
struct Truth { seen: std::collections::BTreeSet<(i32, i32)> }
fn reachable(segs: &[Seg]) -> std::collections::BTreeSet<(i32, i32)> {
    let free = |c: (i32, i32)| { let p = [c.0 as f32 * 0.1, c.1 as f32 * 0.1]; segs.iter().all(|s| near_seg(p, s).1 > 0.18) };
    let mut seen = std::collections::BTreeSet::from([(0, 0)]);
    let mut front = vec![(0, 0)];
    while let Some((x, y)) = front.pop() {
        for n in [(x + 1, y), (x - 1, y), (x, y + 1), (x, y - 1)] { if !seen.contains(&n) && free(n) { seen.insert(n); front.push(n); } }
    }
    seen
}
fn judge(segs: Vec<Seg>, most_s: u64, name: &str) -> f32 {
    let goal = reachable(&segs);
    let mut w = World::new(segs, Pose::ORIGIN);
    let mut truth = Truth { seen: std::collections::BTreeSet::new() };
    for _ in 0..25 * most_s {
        w.step();
        let (cx, cy) = ((w.at.x_m * 10.0).round() as i32, (w.at.y_m * 10.0).round() as i32);
        for x in cx - 2..=cx + 2 { for y in cy - 2..=cy + 2 { if slam_core::pose::length(x as f32 * 0.1 - w.at.x_m, y as f32 * 0.1 - w.at.y_m) < 0.125 { truth.seen.insert((x, y)); } } }
        if w.job.is_over() { break; }
    }
    let share = goal.intersection(&truth.seen).count() as f32 / goal.len() as f32;
    let d = w.job.home.map(|h| slam_core::pose::length(h.x_m - w.at.x_m, h.y_m - w.at.y_m));
    eprintln!("{name}: {share:.3} of {:.0} m2, {:?} after {} min, path {:.0} m = {:.2} m per m2 x 0.25, home {:.2} trips {} bumps {} planning {} s", goal.len() as f32 * 0.01, w.job.state(), w.s / 1500, w.job.path_m, 0.25 * w.job.path_m / (goal.len() as f32 * 0.01 * share), d.unwrap_or(9.0), w.job.sheet.border.trips, w.bumps, w.job.progress().seconds_in[3]);
    share
}
/// A wall along x with doors of 0.9 m at these places.
fn wall(y: f32, x0: f32, x1: f32, doors: &[f32]) -> Vec<Seg> {
    let mut s = vec![]; let mut from = x0;
    for d in doors { s.push(([from, y], [*d - 0.45, y])); from = *d + 0.45; }
    s.push(([from, y], [x1, y])); s
}
fn turned(s: Vec<Seg>) -> Vec<Seg> { s.into_iter().map(|(a, b)| ([a[1], a[0]], [b[1], b[0]])).collect() }
#[test]
fn l_larger() {
    let flat = |x0: f32, y0: f32| {
        // 20 x 12 m: a corridor of 1.6 m in the middle with four rooms on each side.
        let mut s = rect(x0, y0, x0 + 20.0, y0 + 12.0);
        s.extend(wall(y0 + 5.2, x0, x0 + 20.0, &[x0 + 2.0, x0 + 7.0, x0 + 13.0, x0 + 18.0]));
        s.extend(wall(y0 + 6.8, x0, x0 + 20.0, &[x0 + 3.0, x0 + 8.0, x0 + 12.0, x0 + 17.0]));
        for k in 1..4 { let x = x0 + 5.0 * k as f32; s.extend([([x, y0], [x, y0 + 5.2]), ([x, y0 + 6.8], [x, y0 + 12.0])]); }
        s
    };
    judge(flat(-1.0, -6.0), 6 * 3600, "20 x 12 flat, from the west end");
    judge(flat(-10.0, -6.0), 6 * 3600, "20 x 12 flat, from the middle");
    judge(flat(-3.0, -1.0), 6 * 3600, "20 x 12 flat, from a room");
    judge(turned(flat(-3.0, -1.0)), 6 * 3600, "12 x 20 flat, from a room");
    // A corridor round a core of 13 m.
    let mut ring = rect(-1.0, -1.0, 16.0, 16.0); ring.extend(rect(1.0, 1.0, 14.0, 14.0));
    judge(ring, 6 * 3600, "ring");
    // U: two rooms of 18 x 3 m side by side that meet at the far end.
    let mut u = rect(-1.0, -1.0, 17.0, 5.2); u.push(([-1.0, 2.1], [15.5, 2.1]));
    judge(u, 6 * 3600, "U of 18 m");
    // T and L.
    let t = vec![([-9.0, -1.0], [9.0, -1.0]), ([9.0, -1.0], [9.0, 1.5]), ([9.0, 1.5], [1.5, 1.5]), ([1.5, 1.5], [1.5, 10.0]), ([1.5, 10.0], [-1.5, 10.0]), ([-1.5, 10.0], [-1.5, 1.5]), ([-1.5, 1.5], [-9.0, 1.5]), ([-9.0, 1.5], [-9.0, -1.0])];
    judge(t, 6 * 3600, "T of 18 x 11 m");
    let l = vec![([-1.0, -1.0], [15.0, -1.0]), ([15.0, -1.0], [15.0, 2.0]), ([15.0, 2.0], [2.0, 2.0]), ([2.0, 2.0], [2.0, 15.0]), ([2.0, 15.0], [-1.0, 15.0]), ([-1.0, 15.0], [-1.0, -1.0])];
    judge(l, 6 * 3600, "L of 16 x 16 m");
    judge(rect(-12.0, -1.0, 12.0, 2.0), 6 * 3600, "corridor 24 x 3 from the middle");
    judge(rect(-1.0, -1.0, 29.0, 1.5), 6 * 3600, "corridor 30 x 2.5");
    let mut s = rect(-1.0, -1.0, 23.0, 3.0);
    for k in 1..6 { let x = 4.0 * k as f32 - 1.0; s.extend([([x, -1.0], [x, 0.5]), ([x, 1.4], [x, 3.0])]); }
    judge(s, 6 * 3600, "six rooms in a row, 24 m");
    judge(rect(-1.0, -1.0, 13.0, 7.0), 6 * 3600, "hall 14 x 8");
}
