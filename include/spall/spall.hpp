// All that a program that uses Spall includes.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "spall/bodies.hpp"
#include "spall/comm.hpp"
#include "spall/error.hpp"
#include "spall/pair_law.hpp"
#include "spall/scene.hpp"
#include "spall/simulation.hpp"
#include "spall/types.hpp"
