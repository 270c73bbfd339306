"""A walker to play with in the browser: `powered-walker explore` (needs bokeh).

- what is walking? `choice`: a walker, what powers it, who decides; and the reach of its sliders;
- how does it walk? `session`: in real time, pushed, fallen, started again;
- what does the laboratory say of it? `views`, computed aside by `aside`;
- what does one see? `page`, of `stage`, `panels`, `controls` and `keys`, served by `server`.

Everything before the last question is plain Python and knows no browser.
"""
