// What a sanitizer makes impossible or slow.
#pragma once

namespace probebake::test {

/// Built with ThreadSanitizer: some ten times slower, and a child of a fork may start no threads.
constexpr bool thread_sanitized() {
#if defined(__SANITIZE_THREAD__)
    return true;
#else
    return false;
#endif
}

/// Built with any sanitizer whose runtime wants to be loaded first.
constexpr bool sanitized() {
#if defined(__SANITIZE_ADDRESS__)
    return true;
#else
    return thread_sanitized();
#endif
}

/// A time that a test allows: more of it where everything is slow.
template <class Time>
constexpr Time patient(Time time) {
    return thread_sanitized() ? 10 * time : time;
}

}  // namespace probebake::test
