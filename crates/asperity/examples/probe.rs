#![allow(clippy::all)]
use asperity::contact::*;
use asperity::correlation::*;
use asperity::map::Grid;
use asperity::random;
use asperity::surface::*;
fn main() {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(std::env::var("T").map_or(1, |t| t.parse().unwrap()))
        .build()
        .unwrap();
    pool.install(|| {
        for n in [64usize, 256, 512, 1024] {
            if let Ok(only) = std::env::var("N") { if only.parse::<usize>().unwrap() != n { continue; } }
            let grid = Grid::new(n, n, 1.0 / n as f64, 1.0 / n as f64).unwrap();
            let q = std::f64::consts::TAU * 4.0;
            // self-affine H 0.8, roll-off 4, cut n/8
            let mut h = vec![0.0; n * n];
            {
                use asperity::fourier::*;
                let fft = RealFft2::new(n, n);
                let xi = random::standard_normal(&mut random::stream(3, "probe", n as u64), n * n);
                let (mut s, mut w) = (fft.spectrum(), fft.workspace());
                fft.forward(&xi, &mut s, &mut w);
                for kx in 0..fft.stored_kx() { for ky in 0..n {
                    let k = (kx as f64).hypot(signed_index(ky, n));
                    let a = if k == 0.0 || k > n as f64 / 8.0 { 0.0 } else { k.max(4.0).powf(-1.8) };
                    s[kx * n + ky] *= a;
                } }
                fft.inverse(&mut s, &mut h, &mut w);
            }
            let _ = q;
            let mut sl = 0.0;
            for r in 0..n { for c in 0..n { let d = (h[r * n + (c + 1) % n] - h[r * n + c]) * n as f64; sl += 2.0 * d * d; } }
            let sl = (sl / (n * n) as f64).sqrt();
            let heights = ndarray::Array2::from_shape_vec((n, n), h.iter().map(|z| z / sl).collect()).unwrap();
            for boundary in [Boundary::Periodic { mean_compliance_m_per_pa: 1.0 }, Boundary::Free] {
                if boundary == Boundary::Free && n > 512 { continue; }
                let hs = HalfSpace::new(grid, 1.0, boundary).unwrap();
                let mut ws = hs.workspace();
                let p = random::standard_normal(&mut random::stream(3, "p", 0), n * n);
                let mut u = vec![0.0; n * n];
                let mut pair = f64::INFINITY;
                for _ in 0..10 { let t = std::time::Instant::now(); hs.displace(&p, &mut u, &mut ws); pair = pair.min(t.elapsed().as_secs_f64()); }
                for mean in [0.005, 0.05, 0.35] {
                    for hardness in [None, Some(0.5)] {
                        let problem = Problem::new(&hs, &heights, Control::MeanPressure { pascal: mean }, hardness).unwrap();
                        let solver = Solver { tolerance: 1e-6, max_iterations: 1000 };
                        let mut best = f64::INFINITY;
                        let mut sol = None;
                        for _ in 0..(3 + 20_000 / n / n) { let t = std::time::Instant::now(); sol = Some(solver.solve_with(&problem, &mut ws).unwrap()); best = best.min(t.elapsed().as_secs_f64()); }
                        let sol = sol.unwrap();
                        println!("{n} {} p {mean} H {hardness:?}: {:.1} % in {} its, {:.2} ms, pair {:.3} ms, per it {:.2} pairs, {:?} {:.1e}", if boundary == Boundary::Free { "free" } else { "peri" }, 100.0 * sol.contact_fraction(), sol.iterations(), best * 1e3, pair * 1e3, best / pair / sol.iterations() as f64, sol.stop_reason(), sol.residual().worst());
                    }
                }
            }
        }
    });
}
