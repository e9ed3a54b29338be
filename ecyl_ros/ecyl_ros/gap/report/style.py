"""The page's style sheet: one typeface, ink and two colours, in light, dark and print."""

from __future__ import annotations

CSS = """
:root {
  --paper: #ffffff; --ink: #1b1f24; --quiet: #5a626b; --rule: #d9dde1; --shade: #f0f2f4;
  --before: #b6410f; --after: #14559e; --taken: #dfa98f;
  --recorded: #8b939b;
  color-scheme: light dark;
}
@media screen and (prefers-color-scheme: dark) {
  :root {
    --paper: #15181c; --ink: #e6e8ea; --quiet: #a2abb4; --rule: #343a41; --shade: #20252a;
    --before: #f0905c; --after: #7ab4f5; --taken: #7d4a30;
    --recorded: #6a7480;
  }
}
* { box-sizing: border-box; }
html { background: var(--paper); -webkit-text-size-adjust: 100%; }
body {
  margin: 0 auto; padding: 1.6rem 1.2rem 3rem; max-width: 62rem;
  background: var(--paper); color: var(--ink);
  font: 1rem/1.5 system-ui, -apple-system, "Segoe UI", Roboto, "Helvetica Neue", Arial, sans-serif;
  font-variant-numeric: tabular-nums lining-nums;
}
h1 { font-size: 1rem; font-weight: 600; margin: 0 0 .3rem; color: var(--quiet); }
h2 {
  font-size: 1.15rem; font-weight: 600; margin: 2.4rem 0 .6rem; padding-top: .7rem;
  border-top: 1px solid var(--rule);
}
h3 { font-size: 1rem; font-weight: 600; margin: 1.5rem 0 .3rem; }
p { margin: .4rem 0; max-width: 46rem; }
p.verdict { font-size: 1.3rem; line-height: 1.4; margin: 0 0 .7rem; max-width: none; }
.quiet, figcaption, .caption { color: var(--quiet); }
.from { overflow-wrap: anywhere; }
.pair { display: grid; grid-template-columns: repeat(2, minmax(0, 1fr)); gap: 1.2rem 1.8rem; }
figure { margin: 0; break-inside: avoid; }
figcaption { font-size: .85rem; line-height: 1.35; }
.keys { display: flex; flex-wrap: wrap; gap: .2rem 1.3rem; font-size: .9rem; margin: 0 0 .8rem; }
.key { display: inline-flex; align-items: center; gap: .45rem; }
.swatch { width: 22px; height: 8px; }
svg.chart { display: block; width: 100%; height: auto; font-size: 12.5px; }
svg text { fill: var(--ink); }
svg .end { text-anchor: end; }
svg .mid { text-anchor: middle; }
.grid { fill: none; stroke: var(--rule); stroke-width: 1; }
.shade { fill: var(--shade); }
.curve { fill: none; stroke-width: 1.4; stroke-linejoin: round; }
.dots { fill: none; stroke: var(--quiet); stroke-width: 2.2; stroke-linecap: round; opacity: .6; }
.thin { stroke-width: .9; }
.band { stroke: none; opacity: .22; }
.curve.recorded { stroke: var(--recorded); stroke-width: 4; }
.curve.before { stroke: var(--before); }
.curve.after { stroke: var(--after); }
.curve.floor { stroke: var(--quiet); stroke-dasharray: 5 4; stroke-width: 1.2; }
.band.before, .bar.before { fill: var(--before); }
.band.after, .bar.after { fill: var(--after); }
.bar.taken { fill: var(--taken); }
.bar.floor { fill: var(--quiet); }
.scroll { overflow-x: auto; margin: .3rem 0 1rem; }
table { border-collapse: collapse; font-size: .93rem; }
.caption { font-size: .9rem; line-height: 1.4; margin: 1.1rem 0 .2rem; }
th, td { padding: .22rem 1.1rem .22rem 0; text-align: left; vertical-align: baseline; }
th { font-weight: 400; }
thead th { color: var(--quiet); border-bottom: 1px solid var(--rule); vertical-align: bottom; }
tbody td, tbody th { border-bottom: 1px solid var(--rule); }
b { font-weight: 600; }
.num { text-align: right; white-space: nowrap; }
td.share { min-width: 7.5rem; }
.part { display: block; height: .5rem; background: var(--before); min-width: 1px; }
.part.time { background: var(--quiet); height: .22rem; margin-top: .12rem; }
svg .sheet { fill: var(--shade); }
svg .span { stroke: var(--after); stroke-width: 1.6; }
svg .found { fill: var(--after); }
dl {
  display: grid; align-content: start; grid-template-columns: max-content 1fr;
  gap: .25rem 1.2rem; margin: .4rem 0;
}
dt { color: var(--quiet); }
dd { margin: 0; overflow-wrap: anywhere; max-width: 46rem; }
ul { margin: .4rem 0; padding-left: 1.1rem; }
li { max-width: 46rem; overflow-wrap: anywhere; }
footer { font-size: .9rem; }
@media (max-width: 44rem) {
  body { padding: 1rem .9rem 2rem; }
  .pair { grid-template-columns: minmax(0, 1fr); gap: 1rem; }
  p.verdict { font-size: 1.12rem; }
  svg.chart { font-size: 13.5px; }
  table { font-size: .86rem; }
  th, td { padding-right: .75rem; }
  dl { grid-template-columns: 6.6rem 1fr; gap: .25rem .8rem; }
  td.share { min-width: 4.5rem; }
}
@media print {
  html { font-size: 10pt; }
  body { padding: 0; max-width: none; }
  h2, h3, .caption, .keys { break-after: avoid; }
  h2 { margin-top: 1.4rem; }
  article { break-inside: avoid; }
  .scroll { overflow: visible; break-inside: avoid; }
  * { print-color-adjust: exact; -webkit-print-color-adjust: exact; }
}
@page { margin: 16mm 15mm; }
"""
