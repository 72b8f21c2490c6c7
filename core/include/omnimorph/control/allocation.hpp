// temporary
#pragma once
#include "joint_allocate.hpp"
namespace omnimorph {
enum class OldRule { fixed_tilt, best_in_window, towards_best_in_range, jointly };
template <class T, int N> struct AllocationSettings {
    AllocationWeights<T, N> weights;
    OldRule rule = OldRule::fixed_tilt;
    PerServo<T> tilt_change;
    int candidates = 3;
    static constexpr auto fields() { using S = AllocationSettings; return std::make_tuple(field("weights", &S::weights), field("rule", &S::rule), field("tilt_change", &S::tilt_change), field("candidates", &S::candidates)); }
};
template <class T, int N> struct AllocationCache {};
template <class T, int N> using AllocationProblem = JointAllocator<T, N>;
template <class T, int N> JointAllocator<T, N> allocation_problem(const Vehicle<T, N>& v, const AllocationWeights<T, N>& w) { return JointAllocator<T, N>(v, w); }
template <class T, int N>
void allocate(const AllocationSettings<T, N>& s, const JointAllocator<T, N>& problem, const Motion<T>& x, const Demand<T>& d, Allocation<T, N>& last, AllocationCache<T, N>&) {
    auto& a = const_cast<JointAllocator<T, N>&>(problem);
    switch (s.rule) {
        case OldRule::fixed_tilt: a.at_fixed_tilt(x, d.acceleration, last); break;
        case OldRule::best_in_window: a.best_in_window(x, d.acceleration, last, s.tilt_change[0], s.candidates); break;
        case OldRule::towards_best_in_range: a.towards_best_in_range(x, d.acceleration, last, s.tilt_change[0], s.candidates); break;
        case OldRule::jointly: a.jointly(x, d.acceleration, last, s.tilt_change); break;
    }
}
}
