#pragma once
// Which threads may wait for a helper. Most requests need none; some turn out to, such as a job of a built-in scene
// that nobody has looked at yet, and must not hold a thread that answers at once.

namespace photond {

/// Thrown in place of waiting for a helper on a thread that may not. Whoever gave the thread its work gives it to one
/// that may, from the beginning: what waits for a helper does so before it changes anything.
struct NeedsHelper {};

/// Of the calling thread.
inline bool& may_wait_for_helper() {
    thread_local bool may_wait = true;
    return may_wait;
}

}  // namespace photond
