#include "penalty_worlds.hpp"
