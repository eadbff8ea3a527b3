import { defineConfig } from "vitest/config";

export default defineConfig({
  server: { host: "127.0.0.1" }, // a bare Debian has no file that says where localhost is
  test: {
    include: ["src/**/*.test.ts"],
    environment: "node",
    setupFiles: ["src/node_globals.ts"],
    // A worker for each file would take longer to start than all of them run.
    pool: "threads",
    isolate: false,
    maxWorkers: 1,
    minWorkers: 1,
    restoreMocks: true,
    unstubGlobals: true,
  },
});
