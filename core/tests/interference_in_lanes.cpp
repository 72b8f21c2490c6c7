// Interference in the lanes of a pack, and with the rotors counted at run time, is what it is alone: random speeds and
// tilts, rotors at rest and both models, on a column of three rotors, each with a servo of its own, beside one that
// stands apart. Exits 0 if every share of thrust agrees to the last bit (which holds with -ffp-contract=off) and lies
// from 0 to 1.
#include <cstdio>
#include <cstdlib>
#include <random>

#include "omnimorph/math/pack.hpp"
#include "omnimorph/model/interference.hpp"

using namespace omnimorph;

namespace {

constexpr int rotors = 4, lanes = 4, rounds = 2000;
using Many = Pack<double, lanes>;

/// Rotors 0 to 2 one below another, the middle one a little to the side; only the numbers that interference reads.
Vehicle<double, rotors> column() {
    const double hub[rotors][3] = {{0, 0, 0.2}, {0.02, 0, 0}, {0, 0, -0.3}, {0.5, 0, 0.1}};
    Vehicle<double, rotors> v{};
    v.n_servos = rotors;
    for (int i = 0; i < rotors; ++i) {
        v.position[i] = {{hub[i][0], hub[i][1], hub[i][2]}};
        v.axis[i] = Vec3<double>::zero();
        v.axis_cosine[i] = {{0, 0, 1}};
        v.axis_sine[i] = {{0, 1, 0}};
        v.servo[i] = i;
    }
    return v;
}

template <class T, int N>
PerRotor<T, N> kept(const Interference<T, N>& interference, const PerServo<T>& tilt, const PerRotor<T, N>& speed) {
    return interference.thrust_kept(interference.weights(trigonometry_of(tilt, rotors)), speed);
}

}  // namespace

int main() {
    std::mt19937 random(3);
    const auto uniform = [&](double low, double high) { return low + (high - low) * (random() / 4294967296.0); };
    bool well = true;
    for (const WakeModel model : {WakeModel::published, WakeModel::blade_element}) {
        const auto vehicle = column();
        const Interference<double, rotors> alone(vehicle, model);
        const Interference<Many, rotors> together(convert<Vehicle<Many, rotors>>(vehicle), model);
        const Interference<double, 0> counted(convert<Vehicle<double, 0>>(vehicle), model);
        int different = 0, losing = 0, wrong = 0;
        for (int round = 0; round < rounds; ++round) {
            PerServo<Many> tilts{};
            PerRotor<Many, rotors> speeds{};
            for (int i = 0; i < rotors; ++i)
                for (int k = 0; k < lanes; ++k) {
                    tilts[i].set(k, uniform(-1.5, 1.5));
                    speeds[i].set(k, random() % 5 == 0 ? 0.0 : uniform(-1000, 1000));
                }
            const auto shares = kept(together, tilts, speeds);
            for (int k = 0; k < lanes; ++k) {
                PerServo<double> tilt{};
                PerRotor<double, rotors> speed{};
                for (int i = 0; i < rotors; ++i) tilt[i] = tilts[i][k], speed[i] = speeds[i][k];
                const auto share = kept(alone, tilt, speed);
                const auto counted_share = kept(counted, tilt, convert<PerRotor<double, 0>>(speed));
                for (int i = 0; i < rotors; ++i) {
                    different += !(shares[i][k] == share[i]) || !(counted_share[i] == share[i]);
                    losing += share[i] < 1;
                    wrong += !(share[i] >= 0 && share[i] <= 1);
                }
            }
        }
        std::printf("%d pairs, %d shares below one, %d differ from those alone, %d are no shares\n", together.n_pairs(),
                    losing, different, wrong);
        well = well && together.n_pairs() == 3 && losing > rounds && different == 0 && wrong == 0;
    }
    return well ? EXIT_SUCCESS : EXIT_FAILURE;
}
