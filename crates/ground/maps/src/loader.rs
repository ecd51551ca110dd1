// SPDX-License-Identifier: MIT OR Apache-2.0
//! A thread that reads tiles beside frames. A frame hands over what it lacks and takes what has come; it never waits.
//!
//! Tiles that the newest frames began to want come first. What no frame wants any more is not read, and what was read
//! for nothing is dropped.

use rustix::time::{ClockId, clock_gettime};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

/// A tile, and the frame that began to want it.
#[derive(Debug, Clone, Copy)]
struct Wish<K> {
    since: usize,
    tile: K,
}

#[derive(Debug)]
struct State<K> {
    /// Not begun yet.
    wishes: Vec<Wish<K>>,
    reading: Option<Wish<K>>,
    arrived: Vec<(Wish<K>, Vec<u8>)>,
    cancelled: usize,
    cpu_ms: f64,
    failed: Option<String>,
    ends: bool,
}

impl<K> Default for State<K> {
    fn default() -> Self {
        Self {
            wishes: Vec::new(),
            reading: None,
            arrived: Vec::new(),
            cancelled: 0,
            cpu_ms: 0.0,
            failed: None,
            ends: false,
        }
    }
}

impl<K: Copy + Ord> State<K> {
    /// The newest wish; of those of one frame the one that it named first.
    fn next(&mut self) -> Option<Wish<K>> {
        let newest = self.wishes.iter().map(|wish| wish.since).max()?;
        let at = self.wishes.iter().position(|wish| wish.since == newest)?;
        Some(self.wishes.remove(at))
    }

    /// Takes what is still wanted of what has arrived, and replaces the wishes.
    fn exchange(&mut self, frame: usize, lacking: &[K], most: usize) -> Vec<(K, Vec<u8>)> {
        let is_wanted = |wish: &Wish<K>| lacking.contains(&wish.tile);
        let asked = self.wishes.len() + self.arrived.len();
        self.wishes.retain(is_wanted);
        self.arrived.retain(|(wish, _)| is_wanted(wish));
        self.cancelled += asked - self.wishes.len() - self.arrived.len();
        // Stable: of one frame's the first that was read.
        self.arrived
            .sort_by_key(|(wish, _)| std::cmp::Reverse(wish.since));
        let taken = self.arrived.len().min(most);
        let taken: Vec<_> = self.arrived.drain(..taken).collect();
        let known = |tile: &K| {
            let arrived = self.arrived.iter().chain(&taken).map(|(wish, _)| wish);
            let mut all = self.wishes.iter().chain(&self.reading).chain(arrived);
            all.any(|wish| wish.tile == *tile)
        };
        let new: Vec<K> = lacking.iter().copied().filter(|it| !known(it)).collect();
        let new = new.into_iter().map(|tile| Wish { since: frame, tile });
        self.wishes.extend(new);
        let taken = taken.into_iter();
        taken.map(|(wish, texels)| (wish.tile, texels)).collect()
    }
}

#[derive(Debug)]
struct Shared<K> {
    state: Mutex<State<K>>,
    changed: Condvar,
}

impl<K> Shared<K> {
    /// What a thread that panicked left is as good as any: a frame sees that the thread is gone.
    fn lock(&self) -> MutexGuard<'_, State<K>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Reads on a thread of its own until it is dropped.
#[derive(Debug)]
pub struct Loader<K> {
    shared: Arc<Shared<K>>,
    thread: Option<JoinHandle<()>>,
}

impl<K: Copy + Ord + Send + 'static> Loader<K> {
    /// Starts the thread.
    ///
    /// - `read`: gives a tile's texels, or why there are none
    #[must_use]
    pub fn start(read: impl Fn(K) -> Result<Vec<u8>, String> + Send + 'static) -> Self {
        let shared = Arc::new(Shared {
            state: Mutex::default(),
            changed: Condvar::new(),
        });
        let own = Arc::clone(&shared);
        Self {
            shared,
            thread: Some(std::thread::spawn(move || work(&own, read))),
        }
    }

    /// Says what a frame wants and lacks, and takes what has come of it.
    ///
    /// - `lacking`: the most urgent first; what it does not name any more is cancelled
    /// - `most`: at most so many tiles are taken; the others wait for the next frame
    ///
    /// # Errors
    /// Why a tile was not read.
    pub fn exchange(
        &self,
        frame: usize,
        lacking: &[K],
        most: usize,
    ) -> Result<Vec<(K, Vec<u8>)>, String> {
        let mut state = self.shared.lock();
        if let Some(why) = &state.failed {
            return Err(why.clone());
        }
        if self.thread.as_ref().is_none_or(JoinHandle::is_finished) {
            return Err("the thread that reads tiles has ended".to_owned());
        }
        let taken = state.exchange(frame, lacking, most);
        self.shared.changed.notify_one();
        Ok(taken)
    }

    /// Requests that frames gave up, before they were read or after.
    #[must_use]
    pub fn cancelled(&self) -> usize {
        self.shared.lock().cancelled
    }

    /// CPU time of the thread, until the tile that it read last.
    #[must_use]
    pub fn cpu_ms(&self) -> f64 {
        self.shared.lock().cpu_ms
    }
}

impl<K> Drop for Loader<K> {
    fn drop(&mut self) {
        self.shared.lock().ends = true;
        self.shared.changed.notify_one();
        if let Some(thread) = self.thread.take() {
            // What it died of was said, or concerns nobody any more.
            let _ = thread.join();
        }
    }
}

fn work<K: Copy + Ord>(shared: &Shared<K>, read: impl Fn(K) -> Result<Vec<u8>, String>) {
    let mut state = shared.lock();
    while !state.ends {
        let Some(wish) = state.next() else {
            let waited = shared.changed.wait(state);
            state = waited.unwrap_or_else(PoisonError::into_inner);
            continue;
        };
        state.reading = Some(wish);
        drop(state);
        let found = read(wish.tile);
        state = shared.lock();
        let used = clock_gettime(ClockId::ThreadCPUTime);
        state.cpu_ms = used.tv_sec as f64 * 1e3 + used.tv_nsec as f64 * 1e-6;
        state.reading = None;
        match found {
            Ok(texels) => state.arrived.push((wish, texels)),
            Err(why) => state.failed = Some(why),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc::channel;
    use std::time::Duration;

    fn tiles(taken: &[(u32, Vec<u8>)]) -> Vec<u32> {
        taken.iter().map(|(tile, _)| *tile).collect()
    }

    #[test]
    fn the_newest_wishes_are_read_first_and_what_is_given_up_is_not() {
        let mut state: State<u32> = State::default();
        assert!(state.exchange(0, &[1, 2], 9).is_empty());
        assert!(state.exchange(1, &[2, 5, 4], 9).is_empty());
        assert_eq!(state.cancelled, 1);
        let order = std::iter::from_fn(|| state.next()).map(|wish| wish.tile);
        assert_eq!(order.collect::<Vec<_>>(), [5, 4, 2]);
        let wish = |since, tile| Wish { since, tile };
        state.arrived = [wish(0, 2), wish(1, 5), wish(1, 4)]
            .map(|wish| (wish, vec![0]))
            .into();
        // One is taken, another waits, and the third is given up after it was read.
        assert_eq!(tiles(&state.exchange(2, &[5, 2], 1)), [5]);
        assert_eq!(state.cancelled, 2);
        assert!(state.wishes.is_empty());
        assert_eq!(tiles(&state.exchange(3, &[2], 1)), [2]);
        // Negative control: none may be taken.
        state.arrived = vec![(wish(3, 6), vec![0])];
        assert!(state.exchange(4, &[6], 0).is_empty());
        assert_eq!(state.arrived.len(), 1);
    }

    #[test]
    fn frames_do_not_wait_and_hear_of_a_tile_that_is_not_there() {
        let (release, waits) = channel::<()>();
        let loader = Loader::start(move |tile: u32| {
            let _ = waits.recv_timeout(Duration::from_secs(20));
            u8::try_from(tile)
                .map(|tile| vec![tile])
                .map_err(|_| format!("tile {tile}"))
        });
        let until = |frame, lacking: &[u32]| {
            for _ in 0..2000 {
                let found = loader.exchange(frame, lacking, 9);
                if found != Ok(Vec::new()) {
                    return found;
                }
                std::thread::sleep(Duration::from_millis(1));
            }
            Err("nothing came".to_owned())
        };
        // The thread waits to be let go, and no frame with it.
        assert_eq!(loader.exchange(0, &[7], 9), Ok(Vec::new()));
        assert_eq!(loader.exchange(1, &[7], 9), Ok(Vec::new()));
        release.send(()).expect("heard");
        assert_eq!(until(2, &[7]), Ok(vec![(7, vec![7])]));
        assert!(loader.cpu_ms() > 0.0 && loader.cpu_ms() < 20_000.0);
        release.send(()).expect("heard");
        // Negative control.
        assert_eq!(until(3, &[700]), Err("tile 700".to_owned()));
    }
}
