// The system calls allowed to a process that reads untrusted input.
#pragma once

namespace taut::scenes {

/// From now on, until its end, this process can have memory, read and write what is open, and end;
/// any other call kills it: none opens a file or a connection, asks for a file's existence, makes,
/// changes or removes one, starts a process, or reaches another one. Does nothing where the kernel
/// has no such filters or refuses them, and on machines other than x86-64 and 64-bit ARM.
void allow_few_calls();

}  // namespace taut::scenes
