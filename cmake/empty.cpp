// Precompiled headers need a target with a source (T4dPrecompiled.cmake).
