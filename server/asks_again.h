#pragma once
// Whose client asks again rather than have its connection held ("Prefer: respond-async", RFC 7240): a browser has six
// connections a host for all its tabs, and a picture that waits for a pass must not take one from a button.

namespace photond {

/// Of the request that the calling thread answers.
inline bool& client_asks_again() {
    thread_local bool asks_again = false;
    return asks_again;
}

}  // namespace photond
