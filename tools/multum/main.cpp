// SPDX-License-Identifier: Apache-2.0
// multum: the command line.
#include "tools/multum/commands.h"

int main(int argc, char** argv) { return multum::run_multum(argc, argv); }
