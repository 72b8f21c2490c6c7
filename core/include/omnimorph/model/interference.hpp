// Rotors in line blow on one another: the share of its thrust that a rotor keeps in the wake of the one upstream.
//
// Two rotors are stacked if, with nothing tilted, their thrust axes are parallel and one hub lies straight below the
// other. A wake leaves a rotor against its thrust, so which of the two is upstream depends on the signs of their speeds
// w: turning the usual way (w > 0) the upper blows on the lower, turning the other way the lower on the upper;
// thrusting towards or away from each other neither is known to lose anything. theta is the angle between the wake and
// the line from the upstream hub to the downstream one; it is 0 untilted, and the tilt itself on OmniMorph. The wake
// arrives with the strength
//
//     kappa = a exp(-(theta / s)^2) |w_up| / |w_down|
//
// because momentum theory has the velocity of the wake, and the inflow of the rotor it meets, each grow with its own
// rotor's speed. It takes away thrust alone: drag torque and power go on with the actual speed.
#pragma once

#include "../math/elementary.hpp"
#include "wrench.hpp"

namespace omnimorph {

/// How much of its thrust a rotor loses in a wake of strength kappa, and how strong wakes are.
enum class WakeModel {
    /// loss = kappa, with a = 0.333 and s = 40 degrees: meets the two published points, 33 % at 0 and 7 % at 50 degrees
    /// of tilt, all speeds equal (Aboudorra et al. 2024, section on mutual interference). The form of the curve is
    /// assumed.
    published,
    /// Blade-element and momentum theory, in units of hover alone: y the thrust, x the inflow through the disc,
    ///
    ///     x (x - kappa) = y,    y = 1 - beta (x - 1),    loss = 1 - y
    ///
    /// (J. G. Leishman, "Principles of Helicopter Aerodynamics", chapters 2 and 3: T = 2 rho A u (u - V) for an inflow
    /// u in an outer flow V, and a blade's thrust falls linearly with its inflow). kappa is the wake's velocity V as a
    /// share of the inflow of hover alone; 1 is full immersion: a developed wake is twice as fast as the inflow that
    /// made it on half the area, so as fast on average. beta = 0.948 makes that cost 40 %, and a = 0.857, s = 42.02
    /// degrees are then the wakes of the published points, 0.857 at 0 and 0.208 at 50 degrees. What follows from the
    /// theory is how the loss depends on the speeds; all three numbers are calibrated.
    blade_element
};

namespace interference {

inline constexpr double in_line = 0.98480775301220805936;  // cos 10 degrees
inline constexpr double degree = 0.01745329251994329577;   // rad
inline constexpr double published_weight = 0.333;          // a
inline constexpr double published_width = 40 * degree;     // s
inline constexpr double blade_weight = 0.857;
inline constexpr double blade_width = 0.73338345099277193;  // 50 degrees / sqrt(ln(0.857 / 0.208))
inline constexpr double beta = 0.948;                       // share of hover thrust lost per unit of inflow

}  // namespace interference

/// The angle theta of a wake: cos theta = constant + cosine cos(alpha) + sine sin(alpha), with the servo of the rotor
/// upstream.
template <class T> struct WakeCosine {
    int servo;
    T constant, cosine, sine;
    OMNIMORPH_FN T at(const TiltTrigonometry<T>& trig) const {
        return constant + cosine * trig.cosine[servo] + sine * trig.sine[servo];
    }
    OMNIMORPH_FN bool is(const WakeCosine& o) const {
        return servo == o.servo && !any(!((constant == o.constant) & ((cosine == o.cosine) & (sine == o.sine))));
    }
};

/// Two rotors in line, and which wake (by its number) blows from one to the other, down or up.
struct StackedPair {
    int above, below, down, up;
};

/// A number for each of the wakes, or pairs, that n rotors can form at most: n (n - 1), two for a pair.
template <class X, int N> struct PerWake {
    static constexpr int rotors = N > 0 ? N : most_rotors;
    X a[rotors > 1 ? rotors * (rotors - 1) : 1];
    OMNIMORPH_FN X& operator[](int k) { return a[k]; }
    OMNIMORPH_FN const X& operator[](int k) const { return a[k]; }
};

/// The stacked pairs of a vehicle, found once, and what their wakes cost.
///
/// Lanes share their pairs: those of the vehicle in lane 0. Tilts and speeds, and the numbers of the geometry, may
/// differ.
template <class T, int N> class Interference {
  public:
    OMNIMORPH_FN Interference(const Vehicle<T, N>& vehicle, WakeModel model) : n_(vehicle.n_rotors), model_(model) {
        for (int a = 0; a < n_; ++a)
            for (int b = 0; b < n_; ++b)
                if (a != b && is_above(vehicle, a, b)) add_pair(vehicle, a, b);
    }

    OMNIMORPH_FN int n_pairs() const { return n_pairs_; }
    OMNIMORPH_FN const StackedPair& pair(int p) const { return pairs_[p]; }

    /// a exp(-(theta / s)^2) of each wake at a tilt; all of this model that needs an exponential.
    OMNIMORPH_FN PerWake<T, N> weights(const TiltTrigonometry<T>& trig) const {
        PerWake<T, N> out;
        for (int k = 0; k < n_wakes_; ++k) out[k] = weight(wakes_[k].at(trig));
        return out;
    }

    /// The share of its thrust c_f w|w| that each rotor keeps at these speeds (rad/s), 0 to 1. A rotor in several wakes
    /// keeps the product; that a rotor which loses thrust also blows less is left out.
    OMNIMORPH_FN PerRotor<T, N> thrust_kept(const PerWake<T, N>& weights, const PerRotor<T, N>& speed) const {
        PerRotor<T, N> kept{};
        for (int i = 0; i < n_; ++i) kept[i] = T(1);
        for (int p = 0; p < n_pairs_; ++p) {
            const int a = pairs_[p].above, b = pairs_[p].below;
            const Mask<T> down = (speed[a] > T(0)) & (speed[b] > T(0)), up = (speed[a] < T(0)) & (speed[b] < T(0));
            const T upstream = abs(select(up, speed[b], speed[a])), downstream = abs(select(up, speed[a], speed[b]));
            // a rotor at rest has no thrust to lose, and is not divided by
            const T ratio = upstream / select(downstream > T(0), downstream, T(1));
            const T share = share_kept(select(up, weights[pairs_[p].up], weights[pairs_[p].down]) * ratio);
            kept[b] = select(down, kept[b] * share, kept[b]);
            kept[a] = select(up, kept[a] * share, kept[a]);
        }
        return kept;
    }

  private:
    OMNIMORPH_FN static Vec3<T> untilted_axis(const Vehicle<T, N>& vehicle, int i) {
        return vehicle.axis[i] + vehicle.axis_cosine[i];
    }

    OMNIMORPH_FN static bool is_above(const Vehicle<T, N>& vehicle, int a, int b) {
        const Vec3<T> za = untilted_axis(vehicle, a), zb = untilted_axis(vehicle, b),
                      way = vehicle.position[b] - vehicle.position[a];
        const double distance = sqrt(double(lane(dot(way, way), 0)));
        const double drop = -double(lane(dot(way, za), 0));
        // of two hubs at the same place neither is above the other
        return distance > 0 && drop >= interference::in_line * distance &&
               double(lane(dot(za, zb), 0)) >= interference::in_line;
    }

    OMNIMORPH_FN void add_pair(const Vehicle<T, N>& vehicle, int a, int b) {
        const Vec3<T> way = vehicle.position[b] - vehicle.position[a];
        const Vec3<T> line = (T(-1) / sqrt(dot(way, way))) * way;  // from below to above
        // the wake leaves along -z downwards (w > 0), along +z upwards (w < 0), and the line turns round with it
        const auto wake_of = [&](int i) {
            return number_of({vehicle.servo[i], dot(vehicle.axis[i], line), dot(vehicle.axis_cosine[i], line),
                              dot(vehicle.axis_sine[i], line)});
        };
        pairs_[n_pairs_++] = {a, b, wake_of(a), wake_of(b)};
    }

    /// Wakes that always leave at the same angle, as all do on a vehicle of one servo, are one.
    OMNIMORPH_FN int number_of(const WakeCosine<T>& wake) {
        for (int k = 0; k < n_wakes_; ++k)
            if (wakes_[k].is(wake)) return k;
        wakes_[n_wakes_] = wake;
        return n_wakes_++;
    }

    OMNIMORPH_FN T weight(const T& cosine_of_angle) const {
        const bool blade = model_ == WakeModel::blade_element;
        const double most = blade ? interference::blade_weight : interference::published_weight;
        const double width = blade ? interference::blade_width : interference::published_width;
        const T angle = acos(cosine_of_angle) * T(1 / width);
        return T(most) * exp(-(angle * angle));
    }

    /// The share of thrust kept in a wake of strength kappa, 0 to 1.
    OMNIMORPH_FN T share_kept(const T& kappa) const {
        if (model_ == WakeModel::published) return T(1) - min(kappa, T(1));
        using interference::beta;
        const T faster = kappa - T(beta);
        const T inflow = T(0.5) * (faster + sqrt(faster * faster + T(4 * (1 + beta))));  // the positive solution x
        // a wake of kappa > 1 + 1/beta would drive the rotor as a windmill; the model ends where no thrust is left
        return clamp(T(1) - T(beta) * (inflow - T(1)), T(0), T(1));
    }

    Count<N> n_;
    WakeModel model_;
    int n_pairs_ = 0, n_wakes_ = 0;
    PerWake<StackedPair, N> pairs_;
    PerWake<WakeCosine<T>, N> wakes_;
};

}  // namespace omnimorph
