#![allow(unsafe_code, clippy::all, clippy::pedantic)]
use std::alloc::*;
use std::sync::atomic::*;
use std::time::*;
struct C;
static H: AtomicIsize = AtomicIsize::new(0);
static P: AtomicIsize = AtomicIsize::new(0);
fn count(n: isize) {
    let h = H.fetch_add(n, Ordering::Relaxed) + n;
    P.fetch_max(h, Ordering::Relaxed);
}
unsafe impl GlobalAlloc for C {
    unsafe fn alloc(&self, l: Layout) -> *mut u8 {
        count(l.size() as isize);
        unsafe { System.alloc(l) }
    }
    unsafe fn alloc_zeroed(&self, l: Layout) -> *mut u8 {
        count(l.size() as isize);
        unsafe { System.alloc_zeroed(l) }
    }
    unsafe fn dealloc(&self, p: *mut u8, l: Layout) {
        count(-(l.size() as isize));
        unsafe { System.dealloc(p, l) }
    }
    unsafe fn realloc(&self, p: *mut u8, l: Layout, s: usize) -> *mut u8 {
        count(s as isize);
        count(-(l.size() as isize));
        unsafe { System.realloc(p, l, s) }
    }
}
#[global_allocator]
static A: C = C;
fn cpu() -> f64 {
    let s = std::fs::read_to_string("/proc/self/stat").unwrap();
    let f: Vec<&str> = s.rsplit(')').next().unwrap().split_whitespace().collect();
    (f[11].parse::<f64>().unwrap() + f[12].parse::<f64>().unwrap()) / 100.0
}
fn main() {
    for a in std::env::args().skip(1) {
        let b = std::fs::read(&a).unwrap();
        let h0 = H.load(Ordering::Relaxed);
        P.store(h0, Ordering::Relaxed);
        let c0 = cpu();
        let t = Instant::now();
        let r = std::panic::catch_unwind(|| {
            let d = asperity_formats::Format::detect(&b);
            (d, asperity_formats::read_bytes(&b))
        });
        let el = t.elapsed();
        let c = cpu() - c0;
        let pk = P.load(Ordering::Relaxed) - h0;
        let lim = (64 << 20) + 2 * b.len() as isize;
        let (what, pts) = match &r {
            Err(_) => ("PANIC".into(), 0),
            Ok((d, Ok(s))) => (
                format!(
                    "{d:?} {:?} md={} warn={} ch={} {}",
                    s.heights_m.dim(),
                    s.metadata.len(),
                    s.warnings.iter().map(|w| w.len()).sum::<usize>(),
                    s.channels.len(),
                    s.warnings.first().map(|w| w.chars().take(100).collect::<String>()).unwrap_or_default()
                ),
                s.heights_m.len(),
            ),
            Ok((d, Err(e))) => {
                let m = e.to_string();
                (format!("{d:?} ERR[{}] {}", m.len(), m.chars().take(150).collect::<String>().escape_debug()), 0)
            }
        };
        let flag = format!(
            "{}{}",
            if el > Duration::from_secs(2) || c > 2.0 { "SLOW " } else { "" },
            if pk > lim + 8 * pts as isize {
                "MEM!! "
            } else if pk > lim {
                "mem "
            } else {
                ""
            }
        );
        println!(
            "{:<28} {:>6.1}MB {:>7.3}s cpu {:>5.2} peak {:>7.1}MB x{:<5.1} {flag}{what}",
            a.rsplit('/').next().unwrap(),
            b.len() as f64 / 1e6,
            el.as_secs_f64(),
            c,
            pk as f64 / 1e6,
            pk as f64 / b.len() as f64
        );
    }
}
