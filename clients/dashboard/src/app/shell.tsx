// What is about every room: where one can go, how the daemon is, dark or light.

import type { ComponentChildren } from "preact";
import { useLocation } from "preact-iso";
import { useLayoutEffect, useMemo, useRef, useState } from "preact/hooks";

import { connection, daemonStatus } from "../api/events";
import { signOut } from "../api/shared";
import { needsToken, token } from "../api/token";
import { Toasts } from "../ui/toasts";
import { Keyboard, showKeys, useKeys } from "./keyboard";
import { SignIn } from "./sign_in";
import { nextTheme, theme } from "./theme";

const kRooms = [
  { path: "/", name: "Now", key: "n" },
  { path: "/jobs", name: "Jobs", key: "j" },
  { path: "/compare", name: "Compare images", key: "c" },
  { path: "/studies", name: "Studies", key: "s" },
  { path: "/sequences", name: "Sequences", key: "q" },
  { path: "/scenes", name: "Scenes", key: "e" },
];

const isHere = (room: string, path: string) => (room === "/" ? path === "/" : path === room || path.startsWith(`${room}/`));

function Health() {
  const status = daemonStatus.value;
  const lost = connection.value === "lost";
  const text = lost
    ? "The daemon does not answer"
    : status
      ? `${status.queue.running} running, ${status.queue.queued} waiting`
      : "Connecting …";
  return (
    <p class={`health ${lost ? "lost" : connection.value}`} role="status">
      <span class="lamp" aria-hidden="true" />
      {text}
    </p>
  );
}

function Navigation() {
  const { path, route } = useLocation();
  const keys = useMemo(
    () => [
      ...kRooms.map((room) => ({ key: `g ${room.key}`, text: `go to ${room.name}`, run: () => route(room.path) })),
      { key: "N", text: "new comparison", run: () => route("/studies/new") },
      { key: "R", text: "render an image", run: () => route("/render") },
    ],
    [route],
  );
  useKeys("Everywhere", keys, [keys]);
  return (
    <nav class="rooms" aria-label="Rooms">
      {kRooms.map((room) => (
        <a key={room.path} href={room.path} aria-current={isHere(room.path, path) ? "page" : undefined}>
          {room.name}
        </a>
      ))}
    </nav>
  );
}

/** Whether the menu is open that a narrow window has in the place of a row of rooms; whatever one does elsewhere closes it. */
function useMenu() {
  const [open, setOpen] = useState(false);
  const bar = useRef<HTMLElement>(null);
  // With the drawing and not after it: the key or the touch that closes the menu may come before the next frame.
  useLayoutEffect(() => {
    if (!open) return;
    const close = () => setOpen(false);
    const elsewhere = (event: Event) => bar.current?.contains(event.target as Node) || close();
    const escape = (event: KeyboardEvent) => event.key === "Escape" && close();
    document.addEventListener("pointerdown", elsewhere);
    document.addEventListener("focusin", elsewhere);
    document.addEventListener("keydown", escape);
    return () => {
      document.removeEventListener("pointerdown", elsewhere);
      document.removeEventListener("focusin", elsewhere);
      document.removeEventListener("keydown", escape);
    };
  }, [open]);
  return { open, setOpen, bar };
}

function Bar() {
  const { open, setOpen, bar } = useMenu();
  return (
    <header class="bar" ref={bar}>
      <a class="brand" href="/" aria-label="photond, what it does now">
        <img src="/favicon.svg" width="24" height="24" alt="" />
        photond
      </a>
      <Health />
      <button class="bar-menu" aria-expanded={open} aria-controls="bar-more" onClick={() => setOpen(!open)}>
        Menu
      </button>
      <div
        id="bar-more"
        class={open ? "bar-more open" : "bar-more"}
        onClick={(event) => {
          if ((event.target as Element).closest("a, .bar-leaves")) setOpen(false);
        }}
      >
        <Navigation />
        <div class="bar-end">
          <a class="button" href="/render">
            Render
          </a>
          <a class="button primary" href="/studies/new">
            Compare methods
          </a>
          <button class="quiet" onClick={nextTheme} title="Dark, light, or as the system has it">
            {theme.value === "system" ? "Auto" : theme.value === "dark" ? "Dark" : "Light"}
          </button>
          {token() !== null && (
            <button class="quiet" onClick={signOut} title="In all tabs of this browser">
              Sign out
            </button>
          )}
          <button class="quiet bar-leaves" onClick={showKeys} aria-label="Keys" title="Keys (?)">
            ?
          </button>
        </div>
      </div>
    </header>
  );
}

export function Shell({ children }: { children: ComponentChildren }) {
  if (needsToken.value)
    return (
      <main id="room" class="narrow">
        <SignIn />
      </main>
    );
  return (
    <>
      <a class="skip" href="#room">
        Skip to the content
      </a>
      <Bar />
      <main id="room">{children}</main>
      <footer class="about">
        photond {daemonStatus.value?.version} · everything here is there{" "}
<a href="/api">by HTTP too</a>
      </footer>
      <Toasts />
      <Keyboard />
    </>
  );
}
