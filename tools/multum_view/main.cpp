// SPDX-License-Identifier: Apache-2.0
// The program multum-view reads a baked map and a mesh, renders them with runtime_gl, and compares them with the
// reference and with existing methods. It writes pictures and errors.
#include "host/foundation/base/error.h"
#include "tools/multum_view/command_line.h"

int main(int argc, char** argv) { return multum::run_guarded("multum-view", multum::run_view_command, argc, argv); }
