// Makes the figures of a report interactive when they come into view.

import { Figure } from "./figure";
import * as machine from "./machine/page";

/** Offers a text as a file. */
function save(name: string, type: string, text: string) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([text], { type }));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

/** Starts the figure of an element, with a button that saves the drawing of its file. */
function start(host: HTMLElement) {
  const drawing = host.querySelector<HTMLElement>(".drawing");
  const svg = drawing?.querySelector("svg");
  if (!drawing || !svg) return;
  const text = `${new XMLSerializer().serializeToString(svg)}\n`;
  const name = host.id.replace(/^figure-/, "");
  const button = Object.assign(document.createElement("button"), { type: "button", textContent: "SVG", className: "save" });
  button.setAttribute("aria-label", `SVG of ${name.replaceAll("_", " ")}`);
  button.addEventListener("click", () => save(`${name}.svg`, "image/svg+xml", text));
  host.querySelector("h3")?.after(button);
  new Figure(drawing);
}

/** Calls a function once when an element is about to come into view. */
function whenNear(element: HTMLElement, act: () => void) {
  const observer = new IntersectionObserver(
    (entries) => {
      if (!entries.some(({ isIntersecting }) => isIntersecting)) return;
      observer.disconnect();
      act();
    },
    { rootMargin: "300px" },
  );
  observer.observe(element);
}

/** Opens the folded entry that holds the target of a link; some browsers do not. */
function reveal() {
  const entry = document.getElementById(location.hash.slice(1))?.closest("details");
  if (entry) entry.open = true;
}
addEventListener("hashchange", reveal);
reveal();

for (const figure of document.querySelectorAll<HTMLElement>("figure[id]")) whenNear(figure, () => start(figure));
const movable = document.getElementById("move");
if (movable) whenNear(movable, machine.start);
