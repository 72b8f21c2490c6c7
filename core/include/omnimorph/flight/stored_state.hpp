// A state of a flight, or of a plant or controller by itself, as bytes, from which it is resumed, the same to the last
// bit.
#pragma once

#include <string>
#include <vector>

#include "loop.hpp"

namespace omnimorph {

namespace stored {

/// The names and sizes of everything that a record holds, in order.
template <class X> void describe(std::string& layout) {
    if constexpr (fields::is_record<X>) {
        fields::expect_every_member<X>();
        const auto one = [&](const auto& f) {
            layout += f.name;
            layout += '{';
            describe<std::decay_t<decltype(std::declval<X&>().*f.place)>>(layout);
            layout += '}';
        };
        X::fields()([&](const auto&... f) { (one(f), ...); });
    } else if constexpr (fields::is_array<X>) {
        using Elements = std::remove_reference_t<decltype(fields::elements_of(std::declval<X&>()))>;
        layout += std::to_string(std::extent_v<Elements>) + 'x';
        describe<std::remove_extent_t<Elements>>(layout);
    } else {
        layout += std::to_string(sizeof(X));
    }
}

/// FNV-1a
template <class Bytes> std::uint64_t hash_of(Bytes first, Bytes last) {
    std::uint64_t hash = 0xcbf29ce484222325u;
    for (; first != last; ++first) hash = (hash ^ static_cast<unsigned char>(*first)) * 0x100000001b3u;
    return hash;
}

/// States whose records differ in any field have different versions.
template <class X> std::uint64_t version_of() {
    std::string layout;
    describe<X>(layout);
    return hash_of(layout.begin(), layout.end());
}

template <class X> void append(std::vector<unsigned char>& bytes, const X& record) {
    for_each_number(const_cast<X&>(record), record, [&](auto& x, const auto&) {
        const auto* first = reinterpret_cast<const unsigned char*>(&x);
        bytes.insert(bytes.end(), first, first + sizeof(x));
    });
}
/// From `at` on; false, if the bytes end before the record does.
template <class X> bool extract(const std::vector<unsigned char>& bytes, std::size_t& at, X& record) {
    bool there = true;
    for_each_number(record, record, [&](auto& x, const auto&) {
        there = there && at + sizeof(x) <= bytes.size();
        if constexpr (std::is_same_v<std::decay_t<decltype(x)>, bool>) {
            if (there) x = bytes[at] != 0;
        } else {
            if (there) std::memcpy(&x, bytes.data() + at, sizeof(x));
        }
        at += sizeof(x);
    });
    return there;
}

}  // namespace stored

/// What a state is one of. A plant has no controller's part of it, and a controller no plant's.
enum class StoredKind : std::int64_t { flight, plant, controller };

inline const char* name_of(StoredKind kind) {
    return kind == StoredKind::flight ? "flight" : kind == StoredKind::plant ? "plant" : "controller";
}

/// What stands before a stored state.
struct StateHeader {
    std::uint64_t version = stored::version_of<FlightState<double, 0>>() ^ stored::version_of<DelayLine<double, 0>>();
    StoredKind kind = StoredKind::flight;
    std::int64_t n_rotors = 0, n_servos = 0, has_delay_line = 0;
    std::int64_t control_every = 0;  // physics steps
    double physics_step = 0;         // s: the time of a state is counted in it
    std::uint64_t hash = 0;          // of all that follows

    static constexpr auto fields() {
        using H = StateHeader;
        return field_list(field("version", &H::version), field("kind", &H::kind), field("n_rotors", &H::n_rotors),
                          field("n_servos", &H::n_servos), field("has_delay_line", &H::has_delay_line),
                          field("control_every", &H::control_every), field("physics_step", &H::physics_step),
                          field("hash", &H::hash));
    }
    /// Whether what it counts is the same.
    bool is_like(const StateHeader& o) const {
        return n_rotors == o.n_rotors && n_servos == o.n_servos && has_delay_line == o.has_delay_line &&
               control_every == o.control_every && physics_step == o.physics_step;
    }
};

/// A state, and the commands under way if there is a delay (else null).
inline std::vector<unsigned char> store(StateHeader header, const FlightState<double, 0>& state,
                                        const DelayLine<double, 0>* delay_line) {
    std::vector<unsigned char> bytes, numbers;
    stored::append(numbers, state);
    if (delay_line != nullptr) stored::append(numbers, *delay_line);
    header.has_delay_line = delay_line != nullptr;
    header.hash = stored::hash_of(numbers.begin(), numbers.end());
    stored::append(bytes, header);
    bytes.insert(bytes.end(), numbers.begin(), numbers.end());
    return bytes;
}

enum class Stored { read, of_another_version, of_another_kind, of_another_flight, broken };

/// Whether a flight can be in this state; numbers apart, of which any may be.
inline bool is_possible(const FlightState<double, 0>& state, const DelayLine<double, 0>* line) {
    const bool counts = state.step >= 0 && state.last_step[0] >= 0 && state.last_step[0] <= state.step;
    const bool status = state.status[0] >= FlightStatus::flying && state.status[0] <= FlightStatus::part_failed;
    const bool under_way =  // at most one command was sent in a step
        line == nullptr || (line->oldest >= 0 && line->oldest <= line->newest && line->newest <= state.step + 1 &&
                            line->newest - line->oldest <= line->places);
    return counts && status && under_way;
}

/// Read a state that belongs to a flight with this header.
inline Stored read_state(const std::vector<unsigned char>& bytes, const StateHeader& expected,
                         FlightState<double, 0>& state, DelayLine<double, 0>* delay_line) {
    std::size_t at = 0;
    StateHeader header;
    if (!stored::extract(bytes, at, header)) return Stored::broken;
    if (header.version != expected.version) return Stored::of_another_version;
    if (header.kind != expected.kind) return Stored::of_another_kind;
    if (!header.is_like(expected)) return Stored::of_another_flight;
    if (header.hash != stored::hash_of(bytes.begin() + static_cast<long>(at), bytes.end())) return Stored::broken;
    const bool there =
        stored::extract(bytes, at, state) && (delay_line == nullptr || stored::extract(bytes, at, *delay_line));
    return there && at == bytes.size() && is_possible(state, delay_line) ? Stored::read : Stored::broken;
}

}  // namespace omnimorph
