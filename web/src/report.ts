// Makes the figures of a report interactive when they come into view. The static figure stays for printing.

import { FigureView } from "./chart";
import type { Chart, Figure, Values } from "./figure";

/** Offers a text as a file. */
function save(name: string, type: string, text: string) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([text], { type }));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

/** A cell of a CSV file; words that a spreadsheet would compute are quoted with a leading apostrophe. */
function cell(value: string | number | null): string {
  if (value === null || typeof value === "number") return value === null ? "" : String(value);
  const text = /^[=+\-@\t\r]/.test(value) ? `'${value}` : value;
  return `"${text.replaceAll('"', '""')}"`;
}

/** The series of a chart as rows of chart, series and two coordinates. */
function rows({ title, x, y, series }: Chart): string[] {
  const of = (name: string, xs: Values, ys: Values) => xs.map((value, i) => [title, name, value, ys[i] ?? null].map(cell).join());
  const lines = series.flatMap((one): string[] => {
    switch (one.mark) {
      case "line":
      case "dots":
        return of(one.name, one.x, one.y);
      case "band":
        return [...of(`${one.name}, low`, one.x, one.low), ...of(`${one.name}, high`, one.x, one.high)];
      case "bars":
        return of(one.name, one.edges.slice(0, -1).map((edge, i) => ((edge ?? NaN) + (one.edges[i + 1] ?? NaN)) / 2), one.y);
      case "symbol":
        return of(one.name, [one.x], [one.y]);
      case "span":
        return of([one.name, y.names?.[Math.round(one.y)] ?? ""].filter((text) => text !== "").join(", "), [one.low, one.high], [one.y, one.y]);
      case "vertical":
        return of(one.name, [one.at], [null]);
      case "horizontal":
        return of(one.name, [null], [one.at]);
      default:
        return [];
    }
  });
  return [["chart", "series", x.label, y.label].map(cell).join(), ...lines];
}

function start(host: HTMLElement) {
  const data = host.querySelector<HTMLScriptElement>("script[type='application/json']");
  const svg = host.querySelector<SVGSVGElement>(".static svg");
  const name = host.id.replace(/^figure-/, "");
  const tools = document.createElement("div");
  tools.className = "tools files";
  const offer = (text: string, act: () => void) => {
    const button = Object.assign(document.createElement("button"), { type: "button", textContent: text });
    button.setAttribute("aria-label", `${text} of ${name.replaceAll("_", " ")}`);
    button.addEventListener("click", act);
    tools.append(button);
  };
  if (svg) offer("SVG", () => save(`${name}.svg`, "image/svg+xml", svg.outerHTML));
  if (data?.textContent) {
    const figure = JSON.parse(data.textContent) as Figure;
    if (figure.charts.some((chart) => rows(chart).length > 1)) {
      offer("CSV", () => save(`${name}.csv`, "text/csv", figure.charts.flatMap(rows).join("\n") + "\n"));
    }
    const live = document.createElement("div");
    live.className = "live";
    host.querySelector(".static")?.before(live);
    host.classList.add("interactive");
    new FigureView(live, figure);
  }
  host.querySelector("h3")?.after(tools);
}

const observer = new IntersectionObserver(
  (entries) => {
    for (const { isIntersecting, target } of entries) {
      if (isIntersecting) {
        observer.unobserve(target);
        start(target as HTMLElement);
      }
    }
  },
  { rootMargin: "300px" },
);
for (const figure of document.querySelectorAll("figure[id]")) observer.observe(figure);
