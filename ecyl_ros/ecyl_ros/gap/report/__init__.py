"""What a diagnosis looks like to a reader: a page of HTML and a summary for the terminal.

`page.report_html` makes the page, `terminal.summary` the text; both start from the same sentence,
`verdict.sentence`, and render a `Diagnosis` alone: nothing is computed again but pictures.
"""
