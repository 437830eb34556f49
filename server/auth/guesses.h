#pragma once

#include <string>
#include <string_view>
#include <vector>

// How many guesses a password takes of somebody who knows what people choose. Thread safety: pure
// function, any thread.
//
// The password is cut into pieces, each of which is tried in the order in which people choose them;
// what no piece explains counts 10 a character. The guesses of all pieces are multiplied, and by
// the number of orders in which so many pieces can stand; of all ways to cut, the cheapest counts.
// After D. L. Wheeler, "zxcvbn: low-budget password strength estimation", USENIX Security 2016,
// without its term for not knowing how many pieces there are: "Summer2026!" is one common shape.
//
// | piece | guesses |
// |---|---|
// | one of CommonPasswords, or of words at hand here (`guesses.cpp`) | its rank; twice for
// capitals, for "p@ssw0rd", for backwards | | a part of what is known of its owner | 1, and the
// same | | neighbours on a keyboard | 47 keys, its length, 5 for each turn | | neighbours in the
// alphabet, digits in a row | 4 from a usual beginning (a, z, 0, 1, 9), else 26 or 10; its length;
// twice backwards | | a piece again and again | of that piece, times how often | | a year, a date |
// 120 years; 366 days, twice for the order, 4 times for what stands between |
namespace enamel::server::auth {

// log10 of the guesses. `known`: what is known of the owner, login and name, each as a whole; a
// name's words, and a login's parts, of three letters and more count by themselves too.
double Log10Guesses(std::string_view password, const std::vector<std::string_view>& known);

}  // namespace enamel::server::auth
