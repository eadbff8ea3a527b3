// Dark and light: as the system says until told otherwise.

import { signal } from "@preact/signals";

export type Theme = "system" | "light" | "dark";
const kKey = "photond.theme";
const order: Theme[] = ["system", "light", "dark"];

const stored = localStorage.getItem(kKey);
export const theme = signal<Theme>(order.includes(stored as Theme) ? (stored as Theme) : "system");

const systemDark = matchMedia("(prefers-color-scheme: dark)");
/** Whether the page is dark now. Charts that carry their own colours follow it. */
export const isDark = signal(false);

export function applyTheme(): void {
  isDark.value = theme.value === "dark" || (theme.value === "system" && systemDark.matches);
  document.documentElement.dataset.theme = isDark.value ? "dark" : "light";
}
systemDark.addEventListener("change", applyTheme);

export function nextTheme(): void {
  theme.value = order[(order.indexOf(theme.value) + 1) % order.length]!;
  localStorage.setItem(kKey, theme.value);
  applyTheme();
}
