//! Calibrates a stereo pair through the shared library: plain extern "C", std
//! only.
//!
//!     stereo DATA [--check REFERENCE_PAIRS]
//!
//! DATA is a folder with cameras.csv and observations.csv in metres, and the
//! first two cameras are the pair. First of all, every struct declared here is compared
//! with the library's own layout of it. Compiled for a library of double; with --cfg
//! rigcal_float for one of float.
#![allow(non_snake_case, unknown_lints, unexpected_cfgs)]

use std::collections::BTreeMap;
use std::ffi::CStr;
use std::fs;
use std::os::raw::c_char;
use std::process::exit;
use std::ptr;

#[cfg(not(rigcal_float))]
type Real = f64;
#[cfg(rigcal_float)]
type Real = f32;

/// What --check allows: degrees, and metres.
const ANGLE_LIMIT: f64 = 0.05;
const DISTANCE_LIMIT: f64 = 4e-4;
/// RIGCAL_POSES_MAX
const POSES_MAX: usize = 4;

/// Name, offset and size in bytes: a struct, or "struct.field".
type Layout = BTreeMap<String, (usize, usize)>;

fn size_behind<T>(_: *const T) -> usize {
    std::mem::size_of::<T>()
}

/// A struct of rigcal.h under its own name, and how it lies in memory.
macro_rules! c_struct {
    ($name:ident { $($field:ident: $kind:ty),* }) => {
        #[repr(C)]
        #[derive(Clone, Copy)]
        #[allow(non_camel_case_types)]
        struct $name {
            $($field: $kind),*
        }

        impl $name {
            fn zeroed() -> Self {
                // Sound: numbers, arrays of numbers and pointers only.
                unsafe { std::mem::zeroed() }
            }

            fn describe(layout: &mut Layout) {
                let name = stringify!($name);
                let value = Self::zeroed();
                let start = &value as *const Self as usize;
                layout.insert(name.to_string(), (0, size_behind(&value)));
                $(
                    let field = ptr::addr_of!(value.$field);
                    layout.insert(
                        format!("{}.{}", name, stringify!($field)),
                        (field as usize - start, size_behind(field)),
                    );
                )*
            }
        }
    };
}

c_struct!(rigcal_layout_entry { name: [c_char; 48], offset: i32, size: i32 });
c_struct!(rigcal_transform { R: [Real; 9], t: [Real; 3] });
c_struct!(rigcal_camera {
    lens: i32, width: i32, height: i32,
    fx: Real, fy: Real, cx: Real, cy: Real,
    k1: Real, k2: Real, p1: Real, p2: Real,
    k3: Real, k4: Real, k5: Real, k6: Real
});
c_struct!(rigcal_observation { X_w: [Real; 3], uv: [Real; 2] });
c_struct!(rigcal_pose {
    cam_from_world: rigcal_transform, sse: Real, rms_px: Real, probability: Real
});
c_struct!(rigcal_pose_options {
    use_start: i32, sigma_px: Real, start: rigcal_transform
});
c_struct!(rigcal_view {
    camera: *const rigcal_camera, observations: *const rigcal_observation,
    sigma: *const Real, n: usize
});
c_struct!(rigcal_rig_view {
    view: rigcal_view, camera: i32, placement: i32, target: i32
});
c_struct!(rigcal_view_pose {
    cam_from_target: rigcal_transform, information: [Real; 21], sse: Real, n: usize,
    camera: i32, placement: i32
});
c_struct!(rigcal_rig {
    cams_from_rig: *mut rigcal_transform, n_cameras: usize,
    rig_from_placements: *mut rigcal_transform, n_placements: usize,
    group: *mut i32, n_views: usize,
    views: *const rigcal_rig_view, view_source: *const u8,
    view_poses: *const rigcal_view_pose, view_pose_source: *const u8,
    context: *mut u8, left_out: *const u8, roles: *const u8, priors: *const u8,
    priors_information: *const Real, sigma_px: Real,
    work: *mut Real, work_capacity: usize,
    clocks: *mut u8, intrinsics_sigmas: *const u8, considered: *const u8
});
c_struct!(rigcal_rig_fit {
    sum: Real, freedom: Real, sigma_px: Real, n_points: usize, evals: i32,
    F: Real, freedom_between: Real, freedom_within: Real
});

#[link(name = "rigcal")]
extern "C" {
    fn rigcal_sizeof_real() -> i32;
    fn rigcal_status_text(status: i32) -> *const c_char;
    fn rigcal_layout_count() -> i32;
    fn rigcal_layout(entry: *mut rigcal_layout_entry, index: i32) -> i32;
    fn rigcal_pose_defaults(options: *mut rigcal_pose_options) -> i32;
    fn rigcal_pose_solve(
        poses: *mut rigcal_pose,
        capacity: usize,
        n_found: *mut usize,
        at_fault: *mut i32,
        view: *const rigcal_view,
        options: *const rigcal_pose_options,
    ) -> i32;
    fn rigcal_view_pose_make(
        pose: *mut rigcal_view_pose,
        view: *const rigcal_rig_view,
        cam_from_target: *const rigcal_transform,
    ) -> i32;
    fn rigcal_rig_work(n_free: usize, n_cameras: usize, n_placements: usize) -> usize;
    fn rigcal_rig_join(rig: *mut rigcal_rig, at_fault: *mut i32) -> i32;
    fn rigcal_rig_adjust(
        fit: *mut rigcal_rig_fit,
        at_fault: *mut i32,
        rig: *mut rigcal_rig,
    ) -> i32;
    fn rigcal_transform_between(
        b_from_a: *mut rigcal_transform,
        b_from_world: *const rigcal_transform,
        a_from_world: *const rigcal_transform,
    ) -> i32;
}

fn fail(message: &str) -> ! {
    eprintln!("{}", message);
    exit(1)
}

/// Ends the program when a call failed, and prints the caveat of a call that did not:
/// negative statuses are failures, positive ones come with a result that can be used.
fn must(status: i32, what: &str) {
    if status != 0 {
        let text = unsafe { CStr::from_ptr(rigcal_status_text(status)) };
        let text = format!("{}: {}", what, text.to_string_lossy());
        if status < 0 {
            fail(&text);
        }
        eprintln!("caveat: {}", text);
    }
}

fn layout_here() -> Layout {
    let mut layout = Layout::new();
    rigcal_layout_entry::describe(&mut layout);
    rigcal_transform::describe(&mut layout);
    rigcal_camera::describe(&mut layout);
    rigcal_observation::describe(&mut layout);
    rigcal_pose::describe(&mut layout);
    rigcal_pose_options::describe(&mut layout);
    rigcal_view::describe(&mut layout);
    rigcal_rig_view::describe(&mut layout);
    rigcal_view_pose::describe(&mut layout);
    rigcal_rig::describe(&mut layout);
    rigcal_rig_fit::describe(&mut layout);
    layout
}

/// The library's layout of the structs in `here`.
fn layout_there(here: &Layout) -> Layout {
    let mut layout = Layout::new();
    for index in 0..unsafe { rigcal_layout_count() } {
        let mut entry = rigcal_layout_entry::zeroed();
        must(unsafe { rigcal_layout(&mut entry, index) }, "layout");
        let name = unsafe { CStr::from_ptr(entry.name.as_ptr()) };
        let name = name.to_string_lossy().into_owned();
        if here.contains_key(name.split('.').next().unwrap_or("")) {
            layout.insert(name, (entry.offset as usize, entry.size as usize));
        }
    }
    layout
}

fn check_layout() {
    if unsafe { rigcal_sizeof_real() } as usize != std::mem::size_of::<Real>() {
        fail("the library has another rigcal_real: see --cfg rigcal_float");
    }
    let here = layout_here();
    let there = layout_there(&here);
    for name in here.keys().chain(there.keys()) {
        if here.get(name) != there.get(name) {
            fail(&format!(
                "{}: (offset, size) is {:?} here and {:?} in the library",
                name, here.get(name), there.get(name)
            ));
        }
    }
}

/// A line of a table, by column.
type Row = BTreeMap<String, String>;

fn rows(path: &str) -> Vec<Row> {
    let text = fs::read_to_string(path)
        .unwrap_or_else(|error| fail(&format!("{}: {}", path, error)));
    let mut lines = text.lines();
    let columns: Vec<&str> = lines.next().unwrap_or("").split(',').collect();
    lines
        .map(|line| {
            let cells = line.split(',').map(str::to_string);
            columns.iter().map(|c| c.to_string()).zip(cells).collect()
        })
        .collect()
}

fn text<'a>(row: &'a Row, column: &str) -> &'a str {
    match row.get(column) {
        Some(cell) => cell,
        None => fail(&format!("there is no column {}", column)),
    }
}

fn number(row: &Row, column: &str) -> Real {
    text(row, column)
        .parse()
        .unwrap_or_else(|_| fail(&format!("{} is not a number", column)))
}

fn read_camera(row: &Row) -> rigcal_camera {
    rigcal_camera {
        width: number(row, "width") as i32,
        height: number(row, "height") as i32,
        fx: number(row, "fx"),
        fy: number(row, "fy"),
        cx: number(row, "cx"),
        cy: number(row, "cy"),
        k1: number(row, "k1"),
        k2: number(row, "k2"),
        p1: number(row, "p1"),
        p2: number(row, "p2"),
        k3: number(row, "k3"),
        ..rigcal_camera::zeroed()
    }
}

fn read_observation(row: &Row) -> rigcal_observation {
    rigcal_observation {
        X_w: [number(row, "X"), number(row, "Y"), number(row, "Z")],
        uv: [number(row, "u"), number(row, "v")],
    }
}

/// The pose of one view by itself.
fn solve(view: &rigcal_rig_view, what: &str) -> rigcal_view_pose {
    let mut options = rigcal_pose_options::zeroed();
    let mut poses = [rigcal_pose::zeroed(); POSES_MAX];
    let mut n_found = 0;
    let mut found = rigcal_view_pose::zeroed();
    must(unsafe { rigcal_pose_defaults(&mut options) }, "options");
    let status = unsafe {
        rigcal_pose_solve(
            poses.as_mut_ptr(),
            poses.len(),
            &mut n_found,
            ptr::null_mut(),
            &view.view,
            &options,
        )
    };
    must(status, what);
    must(
        unsafe { rigcal_view_pose_make(&mut found, view, &poses[0].cam_from_world) },
        what,
    );
    found
}

/// What each camera saw in each frame: numbers of frame and camera, their names, the
/// points.
fn read_views(
    cameras: &[Row],
    observations: &[Row],
) -> Vec<(usize, usize, String, Vec<rigcal_observation>)> {
    let mut frames: BTreeMap<&str, Vec<&Row>> = BTreeMap::new();
    for row in observations {
        frames.entry(text(row, "frame")).or_default().push(row);
    }
    let mut views = Vec::new();
    for (placement, (frame, seen)) in frames.iter().enumerate() {
        for (index, camera) in cameras.iter().enumerate() {
            let name = text(camera, "camera");
            let observed: Vec<rigcal_observation> = seen
                .iter()
                .filter(|row| text(row, "camera") == name)
                .map(|row| read_observation(row))
                .collect();
            if !observed.is_empty() {
                let names = format!("camera {name}, frame {frame}");
                views.push((placement, index, names, observed));
            }
        }
    }
    views
}

/// The adjusted pair, and the noise that is left.
fn right_from_left(cameras: &[Row], observations: &[Row]) -> (rigcal_transform, Real) {
    let lenses: Vec<rigcal_camera> = cameras.iter().map(read_camera).collect();
    let seen = read_views(cameras, observations);
    let views: Vec<rigcal_rig_view> = seen
        .iter()
        .map(|(placement, camera, _, observed)| rigcal_rig_view {
            view: rigcal_view {
                camera: &lenses[*camera],
                observations: observed.as_ptr(),
                sigma: ptr::null(),
                n: observed.len(),
            },
            camera: *camera as i32,
            placement: *placement as i32,
            target: 0,
        })
        .collect();
    let view_poses: Vec<rigcal_view_pose> = views
        .iter()
        .zip(&seen)
        .map(|(view, (_, _, names, _))| solve(view, names))
        .collect();
    let n_placements = seen.last().map_or(0, |view| view.0 + 1);
    let mut cams_from_rig = [rigcal_transform::zeroed(); 2];
    let mut placements = vec![rigcal_transform::zeroed(); n_placements];
    let mut group = [0; 2];
    let mut work = vec![0 as Real; unsafe { rigcal_rig_work(1, 2, n_placements) }];
    let mut fit = rigcal_rig_fit::zeroed();
    let mut pair = rigcal_transform::zeroed();
    let mut rig = rigcal_rig {
        cams_from_rig: cams_from_rig.as_mut_ptr(),
        n_cameras: cams_from_rig.len(),
        rig_from_placements: placements.as_mut_ptr(),
        n_placements,
        group: group.as_mut_ptr(),
        n_views: views.len(),
        views: views.as_ptr(),
        view_poses: view_poses.as_ptr(),
        work: work.as_mut_ptr(),
        work_capacity: work.len(),
        ..rigcal_rig::zeroed()
    };
    must(unsafe { rigcal_rig_join(&mut rig, ptr::null_mut()) }, "join");
    if group[1] != group[0] {
        fail("the two cameras never saw the target in one place");
    }
    must(
        unsafe { rigcal_rig_adjust(&mut fit, ptr::null_mut(), &mut rig) },
        "adjust",
    );
    let (left, right) = (&cams_from_rig[0], &cams_from_rig[1]);
    must(unsafe { rigcal_transform_between(&mut pair, right, left) }, "pair");
    (pair, fit.sigma_px)
}

fn distance(a: &[Real], b: &[Real]) -> f64 {
    let squares = a.iter().zip(b).map(|(x, y)| (*x as f64 - *y as f64).powi(2));
    squares.sum::<f64>().sqrt()
}

fn angle_deg(Ra: &[Real; 9], Rb: &[Real; 9]) -> f64 {
    (2.0 * (distance(Ra, Rb) / 8f64.sqrt()).asin()).to_degrees()
}

fn reference(path: &str, left: &str, right: &str) -> rigcal_transform {
    let mut pair = rigcal_transform::zeroed();
    for row in rows(path) {
        if text(&row, "camera_a") == left && text(&row, "camera_b") == right {
            for k in 0..9 {
                pair.R[k] = number(&row, &format!("R{}{}", k / 3 + 1, k % 3 + 1));
            }
            for (k, axis) in ["tx", "ty", "tz"].iter().enumerate() {
                pair.t[k] = number(&row, axis);
            }
            return pair;
        }
    }
    fail(&format!("{} has no {}, {}", path, left, right))
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (data, check) = match arguments.len() {
        1 => (&arguments[0], None),
        3 if arguments[1] == "--check" => (&arguments[0], Some(&arguments[2])),
        _ => fail("usage: stereo DATA [--check REFERENCE_PAIRS]"),
    };
    check_layout();

    let mut cameras = rows(&format!("{}/cameras.csv", data));
    cameras.truncate(2);
    let (left, right) = (text(&cameras[0], "camera"), text(&cameras[1], "camera"));
    let observations = rows(&format!("{}/observations.csv", data));
    let (pair, sigma_px) = right_from_left(&cameras, &observations);
    let still = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
    print!(
        "rust:   {} from {}: baseline {:.2} mm, angle {:.3} degrees, {:.2} px",
        right, left,
        1000.0 * distance(&pair.t, &[0.0; 3]),
        angle_deg(&pair.R, &still),
        sigma_px
    );
    if let Some(path) = check {
        let known = reference(path, left, right);
        let angle = angle_deg(&pair.R, &known.R);
        let length = distance(&pair.t, &known.t);
        print!("; off by {:.3} degrees, {:.2} mm", angle, 1000.0 * length);
        if !(angle <= ANGLE_LIMIT && length <= DISTANCE_LIMIT) {
            println!();
            fail("that is too far from the reference");
        }
    }
    println!();
}
