//! Reader of the points in STL and OBJ files.

use nalgebra::Vector3;

/// Largest number of triangles or lines; a greater count means that the file is damaged.
const MOST: usize = 50_000_000;

/// Vertices of a mesh, in the units of its file, without duplicates.
///
/// Accepts binary and text STL, and OBJ; the content decides which.
///
/// # Errors
/// The line or the byte, the found and the expected content: a file that ends early, a field that is not a number, a file without vertices, a pointer
/// of Git LFS instead of the mesh, another format.
pub fn points(bytes: &[u8]) -> Result<Vec<Vector3<f64>>, String> {
    if bytes.starts_with(b"version https://git-lfs") {
        return Err("found a pointer of Git LFS, expected the mesh itself: fetch it with `git lfs pull`".to_owned());
    }
    let mut found = match binary_count(bytes) {
        Some(count) => binary(bytes, count)?,
        None => text(bytes)?,
    };
    if found.is_empty() {
        return Err("found no vertex, expected an STL or OBJ mesh".to_owned());
    }
    found.sort_by(|a, b| a.iter().partial_cmp(b.iter()).unwrap_or(std::cmp::Ordering::Equal));
    found.dedup();
    Ok(found)
}

/// Number of triangles if this is binary STL: 80 arbitrary bytes, a count, and 50 bytes per triangle. A file without zero bytes is text.
fn binary_count(bytes: &[u8]) -> Option<usize> {
    let count = u32::from_le_bytes(bytes.get(80..84)?.try_into().ok()?) as usize;
    let exact = bytes.len() == 84 + 50 * count.min(MOST);
    (exact || bytes.iter().take(1024).any(|b| *b == 0)).then_some(count)
}

fn binary(bytes: &[u8], count: usize) -> Result<Vec<Vector3<f64>>, String> {
    let triangles = bytes.get(84..).unwrap_or_default();
    if count > MOST || triangles.len() < 50 * count {
        let there = triangles.len() / 50;
        return Err(format!("found {there} triangles, expected the {count} that its head counts: cut off, or no STL"));
    }
    let mut found = Vec::with_capacity(3 * count);
    for (index, triangle) in triangles.chunks_exact(50).take(count).enumerate() {
        for corner in 0..3 {
            let number = |axis: usize| {
                let at = 12 + 12 * corner + 4 * axis;
                triangle
                    .get(at..at + 4)
                    .and_then(|b| b.try_into().ok())
                    .map_or(f64::NAN, |b| f64::from(f32::from_le_bytes(b)))
            };
            let point = Vector3::new(number(0), number(1), number(2));
            if !point.iter().all(|x| x.is_finite()) {
                return Err(format!("triangle {}: found a number that is not finite", index + 1));
            }
            found.push(point);
        }
    }
    Ok(found)
}

fn text(bytes: &[u8]) -> Result<Vec<Vector3<f64>>, String> {
    let text = String::from_utf8_lossy(bytes);
    let start = text.trim_start();
    if start.starts_with('<') {
        return Err("found XML (COLLADA?), expected an STL or OBJ mesh".to_owned());
    }
    let mut found = Vec::new();
    let mut ended = !start.starts_with("solid");
    for (index, line) in text.lines().enumerate() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("vertex" | "v") => {
                let mut number = || words.next().and_then(|word| word.parse::<f64>().ok()).filter(|x| x.is_finite());
                let (Some(x), Some(y), Some(z)) = (number(), number(), number()) else {
                    let shown: String = line.trim().chars().take(60).collect();
                    return Err(format!("line {}: found {shown:?}, expected three finite numbers", index + 1));
                };
                found.push(Vector3::new(x, y, z));
            }
            Some("endsolid") => ended = true,
            _ => {}
        }
    }
    if ended { Ok(found) } else { Err("found no `endsolid`: the file is cut off".to_owned()) }
}
