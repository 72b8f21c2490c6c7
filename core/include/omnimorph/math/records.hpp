// A list of records of different kinds, all of them there, as one plain value: a std::tuple that is trivial to copy.
#pragma once

#include <type_traits>

#include "placement.hpp"

namespace omnimorph {

template <class... Each> struct Records;
template <> struct Records<> {};
template <class First, class... Rest> struct Records<First, Rest...> {
    First first;
    Records<Rest...> rest;
};

/// The record of a kind.
template <class Kind, class First, class... Rest> OMNIMORPH_FN constexpr auto& get(Records<First, Rest...>& list) {
    if constexpr (std::is_same_v<Kind, First>) {
        return list.first;
    } else {
        return get<Kind>(list.rest);
    }
}
template <class Kind, class First, class... Rest>
OMNIMORPH_FN constexpr auto& get(const Records<First, Rest...>& list) {
    if constexpr (std::is_same_v<Kind, First>) {
        return list.first;
    } else {
        return get<Kind>(list.rest);
    }
}

/// visit(record) for each of them, in order.
template <class Visit> OMNIMORPH_FN constexpr void for_each(Records<>&, Visit&&) {}
template <class Visit> OMNIMORPH_FN constexpr void for_each(const Records<>&, Visit&&) {}
template <class First, class... Rest, class Visit>
OMNIMORPH_FN constexpr void for_each(Records<First, Rest...>& list, Visit&& visit) {
    visit(list.first);
    for_each(list.rest, visit);
}
template <class First, class... Rest, class Visit>
OMNIMORPH_FN constexpr void for_each(const Records<First, Rest...>& list, Visit&& visit) {
    visit(list.first);
    for_each(list.rest, visit);
}

}  // namespace omnimorph
