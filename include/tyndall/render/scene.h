/// \file
/// The scene that is rendered.
#pragma once

#include "tyndall/scene/scene.h"
