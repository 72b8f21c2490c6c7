// What the sums over the rows of a flight see of one row, and how they add it up.
#pragma once

#include "../loop.hpp"

namespace omnimorph {

/// A sum over many rows that keeps what is small beside it (W. Kahan, "Further remarks on reducing truncation errors",
/// Communications of the ACM 8, 1965): in single precision a flight's sums would else lose four of their seven digits.
template <class T> struct CompensatedSum {
    T sum = T(0), excess = T(0);

    OMNIMORPH_FN void add(const T& x) {
        const T addend = x - excess, next = sum + addend;
        excess = select(is_finite(next), (next - sum) - addend, T(0));  // an infinite sum stays so
        sum = next;
    }
    OMNIMORPH_FN explicit operator T() const { return sum; }
};

/// One row of the flights in the lanes of T: of it only what a record of a flight holds, too.
template <class T, int N> struct SummedRow {
    const FlightState<T, N>& x;
    const Desired<T>& desired;
    const Vehicle<T, N>& model;        // as the controller knows it
    const Actuators<T, N>& before;     // as they were in the row before; nothing in the first
    T drag_power;                      // of all rotors, by the vehicle that flies, W
    T proof;                           // an allocation whose residual is not larger proves itself
    bool is_first, is_in_last_second;  // the last second of the whole flight
    bool is_decided;                   // whether a control step begins here
    Mask<T> counts;                    // where the flight goes on, and all rows so far were finite

    /// A number to be added up: 0 where the row does not count.
    OMNIMORPH_FN T counted(const T& number) const { return select(counts, number, T(0)); }
    OMNIMORPH_FN void raise(T& largest, const T& number) const {
        largest = select(counts & (number > largest), number, largest);
    }
    OMNIMORPH_FN void lower(T& smallest, const T& number) const {
        smallest = select(counts & (number < smallest), number, smallest);
    }
};

}  // namespace omnimorph
